// Inputs that the fuzzer has found, and the seeds it started from, read again: found/READER/*,
// seeds/READER/*.
#include <gtest/gtest.h>
#include <string>

#include "host/core/base/error.hpp"
#include "tests/fuzz/readers.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

class Found : public testing::TestWithParam<test::FuzzedReader> {};

TEST_P(Found, InputsAreReadOrRefused) {
  const test::FuzzedReader& reader = GetParam();
  const fs::path folder = fs::temp_directory_path() / ("simuli_found_" + std::string(reader.name));
  fs::create_directories(folder);
  std::size_t inputs = 0, accepted = 0;
  for (const char* kind : {"seeds", "found"}) {
    const fs::path from = fs::path(SIMULI_FUZZ_FOUND) / kind / reader.name;
    if (!fs::exists(from)) continue;
    for (const auto& entry : fs::directory_iterator(from)) {
      const fs::path file = folder / reader.file_name;
      fs::copy_file(entry.path(), file, fs::copy_options::overwrite_existing);
      ++inputs;
      try {
        reader.read(file);
        ++accepted;
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << entry.path();
      }
    }
  }
  fs::remove_all(folder);
  EXPECT_GT(inputs, 0U) << "no seed in " << SIMULI_FUZZ_FOUND << "/seeds/" << reader.name;
  EXPECT_EQ(accepted > 0, reader.whole);
}

std::string name_of(const testing::TestParamInfo<test::FuzzedReader>& reader) {
  return std::string(reader.param.name);
}
INSTANTIATE_TEST_SUITE_P(Readers, Found, testing::ValuesIn(test::fuzzed_files()), name_of);
INSTANTIATE_TEST_SUITE_P(Program, Found, testing::ValuesIn(test::fuzzed_program()), name_of);

}  // namespace
}  // namespace simuli
