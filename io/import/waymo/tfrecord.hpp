#pragma once
// TFRecord files. Included by io/*.cpp alone.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace simuli {

/// Records one after the other: length, checksum, bytes, checksum. Checksums are not looked at: a damaged
/// message does not fit its schema.
class TfRecords {
 public:
  /// Error{kInput} when there is nothing to read.
  explicit TfRecords(const std::filesystem::path& file);
  /// False at the end. Error{kInput} for a record that is cut short.
  [[nodiscard]] bool next(std::string& record);
  /// Bytes of the file, and how many of them have been read.
  [[nodiscard]] std::uintmax_t size() const { return bytes_; }
  [[nodiscard]] std::uintmax_t at() const { return at_; }

 private:
  std::string file_;
  std::ifstream in_;
  std::uintmax_t bytes_ = 0, at_ = 0;
};

}  // namespace simuli
