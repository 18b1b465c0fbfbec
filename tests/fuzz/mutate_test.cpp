// Changes of inputs keep their form: otherwise the fuzzer would never get past a checksum or a bracket.
#include <gtest/gtest.h>
#include <set>
#include <string>

#include "io/base/file.hpp"
#include "tests/fuzz/readers.hpp"

namespace simuli {
namespace mutate_test {

namespace fs = std::filesystem;

std::string with_one_byte_changed(const std::string& bytes, std::mt19937& random) {
  std::string out = bytes.empty() ? "x" : bytes;
  out[random() % out.size()] = static_cast<char>(random());
  return out;
}

class Mutated : public testing::TestWithParam<test::FuzzedReader> {};

TEST_P(Mutated, SeedsKeepTheirForm) {
  const test::FuzzedReader& reader = GetParam();
  test::Choice choice{std::mt19937(7), {}};
  choice.bytes = [&](const std::string& bytes, std::size_t most) {
    return with_one_byte_changed(bytes.substr(0, most), choice.random);
  };
  for (const auto& entry : fs::directory_iterator(fs::path(SIMULI_FUZZ_FOUND) / "seeds" / reader.name)) {
    const std::string seed = read_file(entry.path());
    std::set<std::string> different;
    int again = 0;
    constexpr int kTries = 200;
    for (int i = 0; i < kTries; ++i) {
      const auto once = test::mutated(reader.form, seed, choice);
      ASSERT_EQ(once.has_value(), reader.form != test::Form::kBytes) << entry.path();
      if (!once) continue;
      different.insert(*once);
      if (test::mutated(reader.form, *once, choice)) ++again;
    }
    if (reader.form == test::Form::kBytes) continue;
    // Some changes are of what the form itself hangs on: an opening line, a list's last element.
    EXPECT_GT(again, kTries * 3 / 4) << entry.path();
    EXPECT_GT(different.size(), kTries / 4U) << entry.path();
  }
}

std::string name_of(const testing::TestParamInfo<test::FuzzedReader>& reader) {
  return std::string(reader.param.name);
}
INSTANTIATE_TEST_SUITE_P(Readers, Mutated, testing::ValuesIn(test::fuzzed_files()), name_of);
INSTANTIATE_TEST_SUITE_P(Program, Mutated, testing::ValuesIn(test::fuzzed_program()), name_of);

}  // namespace mutate_test
}  // namespace simuli
