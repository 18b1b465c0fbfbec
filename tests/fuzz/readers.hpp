#pragma once
// Every reader of files, as a function of one file's bytes: for the fuzzer, and for the inputs it has found.
#include <filesystem>
#include <span>
#include <string_view>

namespace simuli::test {

struct FuzzedReader {
  std::string_view name;
  /// Reads the file, which holds whatever bytes; throws simuli::Error alone.
  void (*read)(const std::filesystem::path& file);
  std::string_view file_name;  // what the file is called, for readers that look at that
  bool whole = true;           // reads its seeds; false: they lack files that stand beside them
};

[[nodiscard]] std::span<const FuzzedReader> fuzzed_readers();

}  // namespace simuli::test
