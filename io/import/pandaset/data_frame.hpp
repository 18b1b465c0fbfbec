#pragma once
// Tables of pandas (DataFrame) from .pkl and .pkl.gz without Python, for io/import/pandaset/*.cpp and tests.
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/import/pandaset/pickle.hpp"

namespace simuli::pandaset {

/// A NumPy array of numbers or objects.
struct PickledArray {
  std::vector<std::size_t> shape;
  char kind = 'O';        // NumPy's: f, i, u, b (bool), O (objects); others are not supported
  std::size_t bytes = 0;  // per number
  bool is_column_major = false;
  std::string_view data;                               // of numbers, little endian
  const std::vector<std::uint32_t>* values = nullptr;  // of kind O
};

/// Columns by name. Supports pandas 1 to 3 and pickle protocols 2 to 5.
class DataFrame {
 public:
  /// Limit of the decompressed file.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20U;

  /// Throws Error{kInput} naming `file` for data that is not such a table, damaged, or larger than kMostBytes.
  explicit DataFrame(const std::filesystem::path& file);
  /// The same for a pickle in memory.
  DataFrame(std::string bytes, const std::string& file);

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] bool has(const std::string& column) const { return columns_.contains(column); }
  /// Returns [rows] numbers, also for columns of integers and booleans. Throws Error{kInput} naming the column
  /// if it is missing or of another kind.
  [[nodiscard]] std::vector<double> numbers(const std::string& column) const;
  /// Returns [rows] texts; "" for missing values (None, NaN).
  [[nodiscard]] std::vector<std::string> texts(const std::string& column) const;

 private:
  struct Column {
    std::size_t block = 0, row = 0;
  };
  void read_blocks(const PickleValue& manager);
  void add_block(const PickleValue& values, const PickleValue& places);
  void read_names(const PickleValue& index);
  [[nodiscard]] const PickledArray& block_of(const std::string& column, std::size_t& row) const;
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const;

  std::shared_ptr<const Pickle> pickle_;
  std::vector<std::string> names_;
  std::vector<PickledArray> blocks_;  // [columns of the block][rows]
  std::map<std::string, Column> columns_;
  std::size_t rows_ = 0;
};

}  // namespace simuli::pandaset
