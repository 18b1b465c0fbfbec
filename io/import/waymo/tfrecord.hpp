#pragma once
// TFRecord files, for io/*.cpp.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace simuli {

/// Reads records: length, checksum, bytes, checksum. Does not verify checksums: a damaged message does not
/// match its schema.
class TfRecords {
 public:
  /// Throws Error{kInput} for an empty or unreadable file.
  explicit TfRecords(const std::filesystem::path& file);
  /// Returns false at the end. Throws Error{kInput} for a truncated record.
  [[nodiscard]] bool next(std::string& record);
  /// Size of the file and number of bytes read.
  [[nodiscard]] std::uintmax_t size() const { return bytes_; }
  [[nodiscard]] std::uintmax_t at() const { return at_; }

 private:
  std::string file_;
  std::ifstream in_;
  std::uintmax_t bytes_ = 0, at_ = 0;
};

}  // namespace simuli
