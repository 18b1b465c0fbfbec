// One reader under libFuzzer, the one whose name the program is called by:
//   cmake -B build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DSIMULI_FUZZ=ON
//   cmake --build build/fuzz --target fuzz
//   build/fuzz/bin/fuzz_ply found/ tests/fuzz/seeds/ply
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
#include <unistd.h>

#include "host/base/error.hpp"
#include "tests/fuzz/readers.hpp"

namespace {

namespace fs = std::filesystem;

const simuli::test::FuzzedReader* g_reader = nullptr;

/// A file in memory, in a folder of its own.
fs::path make_file() {
  const fs::path folder = fs::path("/dev/shm") / fmt::format("simuli_fuzz_{}_{}", g_reader->name, ::getpid());
  fs::create_directories(folder);
  return folder / g_reader->file_name;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  const std::string program = fs::path((*arguments)[0]).filename().string();
  const auto readers = simuli::test::fuzzed_readers();
  const auto found = std::find_if(readers.begin(), readers.end(), [&](const auto& r) {
    return program == fmt::format("fuzz_{}", r.name);
  });
  if (found == readers.end()) {
    std::cerr << program << ": no reader of that name\n";
    std::exit(2);
  }
  g_reader = &*found;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path file = make_file();
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
