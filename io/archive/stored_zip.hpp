#pragma once
// Zip archives whose files stand in them as they are.
#include <cstddef>
#include <string>

namespace simuli {

/// The bytes of a zip archive without compression and without dates (all are the earliest that zip knows).
class StoredZip {
 public:
  /// `file` is named in errors. What each file holds begins at a multiple of `alignment`: 1, or a power of
  /// two up to 4096.
  explicit StoredZip(std::string file, std::size_t alignment = 1)
      : file_(std::move(file)), alignment_(alignment) {}
  /// Error{kInput} when the archive would have more than 4 GiB.
  void add(const std::string& name, const std::string& bytes);
  [[nodiscard]] std::string finish() const;

 private:
  std::string file_, out_, directory_;
  std::size_t alignment_, count_ = 0;
};

}  // namespace simuli
