#pragma once
// Every reader of files, requests and arguments, as a function of one file's bytes: for the fuzzer, and for
// the inputs it has found.
#include <filesystem>
#include <ostream>
#include <span>
#include <string_view>

#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {

struct FuzzedReader {
  std::string_view name;
  Form form;
  /// Reads the file, which holds whatever bytes; throws simuli::Error alone.
  void (*read)(const std::filesystem::path& file);
  std::string_view file_name;  // what the file is called, for readers that look at that
  bool whole = true;           // reads its seeds; false: they lack files that stand beside them
};
inline void PrintTo(const FuzzedReader& reader, std::ostream* out) { *out << reader.name; }

/// The readers of files.
[[nodiscard]] std::span<const FuzzedReader> fuzzed_files();
/// What of the program itself takes text from others: needs all of it.
[[nodiscard]] std::span<const FuzzedReader> fuzzed_program();

}  // namespace simuli::test
