#pragma once
// Arrays of numbers for NumPy.
#include <cstddef>
#include <string>
#include <vector>

#include "io/archive/stored_zip.hpp"

namespace simuli {

/// The bytes of a .npz file: arrays, little endian and row-major, stored as they are.
class Npz {
 public:
  /// `file` is named in errors.
  explicit Npz(std::string file) : zip_(std::move(file)) {}
  /// dtype: NumPy's, "<f4"; data: the array's bytes. Error{kInput} when the file would have more than 4 GiB.
  void add(const std::string& name,
           const std::string& dtype,
           const std::vector<std::size_t>& shape,
           const std::string& data);
  [[nodiscard]] std::string finish() const;

 private:
  StoredZip zip_;
};

}  // namespace simuli
