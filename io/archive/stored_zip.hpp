#pragma once
// Zip archives of uncompressed files.
#include <cstddef>
#include <string>

namespace simuli {

/// Builds a zip archive without compression and with the earliest possible dates.
class StoredZip {
 public:
  /// `file` is named in errors. The data of each file begins at a multiple of `alignment`: 1, or a power of two
  /// up to 4096.
  explicit StoredZip(std::string file, std::size_t alignment = 1)
      : file_(std::move(file)), alignment_(alignment) {}
  /// Throws Error{kInput} if the archive would exceed 4 GiB.
  void add(const std::string& name, const std::string& bytes);
  [[nodiscard]] std::string finish() const;

 private:
  std::string file_, out_, directory_;
  std::size_t alignment_, count_ = 0;
};

}  // namespace simuli
