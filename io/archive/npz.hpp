#pragma once
// Numeric arrays in NumPy's format.
#include <cstddef>
#include <string>
#include <vector>

#include "io/archive/stored_zip.hpp"

namespace simuli {

/// Builds a .npz file: uncompressed little-endian row-major arrays.
class Npz {
 public:
  /// `file` is named in errors.
  explicit Npz(std::string file) : zip_(std::move(file)) {}
  /// dtype: NumPy's, "<f4"; data: the array's bytes. Throws Error{kInput} if the file would exceed 4 GiB.
  void add(const std::string& name,
           const std::string& dtype,
           const std::vector<std::size_t>& shape,
           const std::string& data);
  [[nodiscard]] std::string finish() const;

 private:
  StoredZip zip_;
};

}  // namespace simuli
