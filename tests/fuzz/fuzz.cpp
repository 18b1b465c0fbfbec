// One of the readers of SIMULI_FUZZED under libFuzzer, the one whose name the program is called by:
// tests/fuzz/run.sh, or
//   cmake -B build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DSIMULI_FUZZ=ON
//   cmake --build build/fuzz --target fuzz
//   build/fuzz/bin/fuzz_ply found/ tests/fuzz/seeds/ply
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <string>
#include <string_view>
#include <system_error>
#include <unistd.h>

#include "host/core/base/error.hpp"
#include "tests/fuzz/readers.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

namespace fs = std::filesystem;

const simuli::test::FuzzedReader* g_reader = nullptr;

/// A folder in memory, as long as the program runs.
class Folder {
 public:
  Folder() : path_(fs::path("/dev/shm") / fmt::format("simuli_fuzz_{}_{}", g_reader->name, ::getpid())) {
    fs::create_directories(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] fs::path operator/(std::string_view name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::string changed(const std::string& bytes, std::size_t most) {
  std::string out = bytes.substr(0, most);
  const std::size_t size = out.size();
  out.resize(most);
  out.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(out.data()), size, most));
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  const std::string program = fs::path((*arguments)[0]).filename().string();
  const auto readers = simuli::test::SIMULI_FUZZED();
  const auto found = std::find_if(readers.begin(), readers.end(), [&](const auto& r) {
    return program == fmt::format("fuzz_{}", r.name);
  });
  if (found == readers.end()) {
    std::cerr << program << ": no reader of that name\n";
    std::exit(2);
  }
  g_reader = &*found;
  // Small pictures: handing them to threads takes longer than reading them.
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", 1);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data,
                                               std::size_t size,
                                               std::size_t most,
                                               unsigned seed) {
  simuli::test::Choice choice{std::mt19937(seed), changed};
  // Now and then the form itself is what has to be wrong.
  if (choice.below(8) != 0) {
    const std::string input(reinterpret_cast<const char*>(data), size);
    const auto output = simuli::test::mutated(g_reader->form, input, choice);
    if (output && !output->empty() && output->size() <= most) {
      std::copy(output->begin(), output->end(), data);
      return output->size();
    }
  }
  return LLVMFuzzerMutate(data, size, most);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  static const fs::path file = folder / g_reader->file_name;
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const bool written = descriptor >= 0 && ::write(descriptor, data, size) == static_cast<ssize_t>(size);
  ::close(descriptor);
  if (!written) std::abort();
  try {
    g_reader->read(file);
  } catch (const simuli::Error& error) {
    // One line, and never longer than a person reads.
    const std::string_view what = error.what();
    if (what.empty() || what.find('\n') != std::string_view::npos) std::abort();
  }
  return 0;
}
