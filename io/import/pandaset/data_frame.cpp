#include "io/import/pandaset/data_frame.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"

namespace simuli::pandaset {
namespace {

/// Reads arrays and tables from values of a pickle, with a check of each value's type.
class Reader {
 public:
  explicit Reader(const Pickle& pickle) : pickle_(pickle) {}

  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(pickle_.file(), field, found, allowed);
  }

  /// Returns the n-th child of a call, a tuple or a list.
  [[nodiscard]] const PickleValue& child(const PickleValue& value, std::size_t n, const char* field) const {
    if (value.kind == PickleKind::kDict || n >= value.children.size())
      refuse(field, "fewer values", fmt::format("at least {}", n + 1));
    return pickle_.at(value.children[n]);
  }
  [[nodiscard]] std::int64_t integer(const PickleValue& value, const char* field) const {
    if (value.kind != PickleKind::kInteger) refuse(field, "no whole number", "one");
    return value.integer;
  }
  [[nodiscard]] std::size_t count(const PickleValue& value, const char* field) const {
    const std::int64_t found = integer(value, field);
    constexpr std::int64_t kMost = std::int64_t{1} << 31U;
    if (found < 0 || found > kMost) refuse(field, fmt::format("{}", found), fmt::format("0 to {}", kMost));
    return static_cast<std::size_t>(found);
  }

  [[nodiscard]] PickledArray array(const PickleValue& value) const {
    if (pickle_.is_of(value, "StringArray") || pickle_.is_of(value, "__pyx_unpickle_NDArrayBacked"))
      return array(array_in_state(value));
    PickledArray out;
    if (pickle_.is_of(value, "_frombuffer")) {  // bytes, type, shape, order
      const PickleValue& arguments = child(value, 1, "array");
      set_type(out, child(arguments, 1, "array"));
      set_shape(out, child(arguments, 2, "shape"));
      out.is_column_major = child(arguments, 3, "order").text == "F";
      set_data(out, child(arguments, 0, "array"));
      return out;
    }
    if (!pickle_.is_of(value, "_reconstruct")) refuse("array", "another value", "an array of NumPy's");
    const PickleValue& state = child(value, 2, "array");  // version, shape, type, order, content
    set_shape(out, child(state, 1, "shape"));
    set_type(out, child(state, 2, "array"));
    out.is_column_major = child(state, 3, "order").integer != 0;
    set_data(out, child(state, 4, "array"));
    return out;
  }

  /// Returns an array of texts.
  [[nodiscard]] std::vector<std::string> texts(const PickleValue& value) const {
    const PickledArray found = array(value);
    if (found.kind != 'O' || found.shape.size() != 1) refuse("columns", "no texts", "a list of names");
    std::vector<std::string> out;
    for (const std::uint32_t i : *found.values) {
      if (pickle_.at(i).kind != PickleKind::kText) refuse("columns", "no text", "names");
      out.emplace_back(pickle_.at(i).text);
    }
    return out;
  }

 private:
  /// Returns the NumPy array inside pandas' array of text.
  [[nodiscard]] const PickleValue& array_in_state(const PickleValue& value) const {
    const PickleValue& state = child(value, 2, "array of text");
    if (state.kind == PickleKind::kTuple || state.kind == PickleKind::kList) {
      for (const std::uint32_t i : state.children) {
        const PickleValue& part = pickle_.at(i);
        if (pickle_.is_of(part, "_reconstruct")) return part;
      }
    }
    const PickleValue* const named = pickle_.find(state, "_ndarray");
    if (named == nullptr || !pickle_.is_of(*named, "_reconstruct"))
      refuse("array of text", "another state", "an array of NumPy's");
    return *named;
  }

  void set_shape(PickledArray& out, const PickleValue& shape) const {
    constexpr std::size_t kMostDimensions = 2;
    if (shape.kind != PickleKind::kTuple || shape.children.empty() || shape.children.size() > kMostDimensions)
      refuse("shape", "another", "1 or 2 dimensions");
    for (std::size_t i = 0; i < shape.children.size(); ++i)
      out.shape.push_back(count(child(shape, i, "shape"), "shape"));
  }

  /// dtype("f8") with the state (version, byte order, ..).
  void set_type(PickledArray& out, const PickleValue& type) const {
    if (!pickle_.is_of(type, "dtype")) refuse("type of an array", "another value", "NumPy's dtype");
    const PickleValue& name = child(child(type, 1, "dtype"), 0, "dtype");
    std::string_view text = name.kind == PickleKind::kText ? name.text : std::string_view{};
    if (type.children.size() > 2 && child(child(type, 2, "dtype"), 1, "dtype").text == ">")
      refuse("dtype", "big endian", "little endian");
    for (const char order : {'<', '|', '='}) {
      if (text.starts_with(order)) text.remove_prefix(1);
    }
    if (text.size() < 2) refuse("dtype", '"' + std::string(text) + '"', "f8, i8, b1, O8 ..");
    out.kind = text[0];
    out.bytes = static_cast<std::size_t>(text[1] - '0');
  }

  void set_data(PickledArray& out, const PickleValue& content) const {
    std::size_t all = 1;
    for (const std::size_t side : out.shape) all *= side;  // two sides of at most 2^31
    if (out.kind == 'O') {
      if (content.kind != PickleKind::kList || content.children.size() != all)
        refuse("array", fmt::format("{} values", content.children.size()), fmt::format("a list of {}", all));
      out.values = &content.children;
      return;
    }
    if (content.kind != PickleKind::kBytes || all > content.text.size() ||
        content.text.size() != all * out.bytes) {
      refuse("array",
             fmt::format("{} bytes", content.text.size()),
             fmt::format("{} numbers of {} bytes", all, out.bytes));
    }
    out.data = content.text;
  }

  const Pickle& pickle_;
};

template <class T>
double number_as(const char* at) {
  static_assert(std::endian::native == std::endian::little, "the files are little endian");
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

using ReadNumber = double (*)(const char*);

/// Returns the reader of a number type; null for unsupported types.
ReadNumber reader_of(char kind, std::size_t bytes) {
  struct Known {
    char kind;
    std::size_t bytes;
    ReadNumber read;
  };
  constexpr Known kKnown[] = {{'f', 8, number_as<double>},
                              {'f', 4, number_as<float>},
                              {'i', 8, number_as<std::int64_t>},
                              {'i', 4, number_as<std::int32_t>},
                              {'i', 2, number_as<std::int16_t>},
                              {'i', 1, number_as<std::int8_t>},
                              {'u', 8, number_as<std::uint64_t>},
                              {'u', 4, number_as<std::uint32_t>},
                              {'u', 2, number_as<std::uint16_t>},
                              {'u', 1, number_as<std::uint8_t>},
                              {'b', 1, number_as<std::uint8_t>}};
  for (const Known& known : kKnown) {
    if (known.kind == kind && known.bytes == bytes) return known.read;
  }
  return nullptr;
}

std::string unpacked(const std::filesystem::path& file) {
  std::string bytes = read_file(file, DataFrame::kMostBytes);
  return is_gzip(bytes) ? gunzip(bytes, file.string(), DataFrame::kMostBytes) : bytes;
}

}  // namespace

DataFrame::DataFrame(const std::filesystem::path& file) : DataFrame(unpacked(file), file.string()) {}

DataFrame::DataFrame(std::string bytes, const std::string& file)
    : pickle_(std::make_shared<const Pickle>(std::move(bytes), file)) {
  const PickleValue& frame = pickle_->root();
  if (frame.kind != PickleKind::kCall || !pickle_->is_of(frame, "DataFrame") || frame.children.size() < 3)
    refuse("content", "another value", "a DataFrame of pandas");
  const PickleValue& state = pickle_->at(frame.children[2]);
  const PickleValue* manager = pickle_->find(state, "_mgr");
  if (manager == nullptr) manager = pickle_->find(state, "_data");
  if (manager == nullptr || !pickle_->is_of(*manager, "BlockManager"))
    refuse("DataFrame", "no columns", "a BlockManager");
  read_blocks(*manager);
}

void DataFrame::refuse(const std::string& field, const std::string& found, const std::string& allowed) const {
  throw_input_error(pickle_->file(), field, found, allowed);
}

/// Newer files call BlockManager(blocks, axes), where each block is a call with values and positions; older
/// files set a state (axes, values, items, {"0.14.1": {"axes", "blocks": [{"values", "mgr_locs"}, ...]}}).
void DataFrame::read_blocks(const PickleValue& manager) {
  const Reader read(*pickle_);
  if (manager.kind != PickleKind::kCall) refuse("BlockManager", "not called", "a call");
  const PickleValue& arguments = read.child(manager, 1, "BlockManager");
  if (!arguments.children.empty()) {
    const PickleValue& blocks = read.child(arguments, 0, "blocks");
    read_names(read.child(read.child(arguments, 1, "axes"), 0, "axes"));
    for (std::size_t i = 0; i < blocks.children.size(); ++i) {
      const PickleValue& block = read.child(blocks, i, "blocks");
      if (!pickle_->is_of(block, "_unpickle_block") && !pickle_->is_of(block, "new_block"))
        refuse("blocks", "another value", "blocks of columns");
      const PickleValue& parts = read.child(block, 1, "block");
      add_block(read.child(parts, 0, "block"), read.child(parts, 1, "block"));
    }
  } else {
    const PickleValue* state = nullptr;
    const PickleValue& all = read.child(manager, 2, "BlockManager");
    if (all.children.size() == 4) state = pickle_->find(read.child(all, 3, "BlockManager"), "0.14.1");
    const PickleValue* const axes = state == nullptr ? nullptr : pickle_->find(*state, "axes");
    const PickleValue* const blocks = state == nullptr ? nullptr : pickle_->find(*state, "blocks");
    if (axes == nullptr || blocks == nullptr) refuse("BlockManager", "another state", "axes and blocks");
    read_names(read.child(*axes, 0, "axes"));
    for (std::size_t i = 0; i < blocks->children.size(); ++i) {
      const PickleValue& block = read.child(*blocks, i, "blocks");
      const PickleValue* const values = pickle_->find(block, "values");
      const PickleValue* const places = pickle_->find(block, "mgr_locs");
      if (values == nullptr || places == nullptr) refuse("blocks", "another value", "values and mgr_locs");
      add_block(*values, *places);
    }
  }
  if (columns_.size() != names_.size()) {
    refuse("columns",
           fmt::format(
               "{} of {} without values, or two of a name", names_.size() - columns_.size(), names_.size()),
           "each with its own");
  }
}

void DataFrame::read_names(const PickleValue& index) {
  const Reader read(*pickle_);
  const PickleValue* names = nullptr;
  if (pickle_->is_of(index, "_new_Index"))
    names = pickle_->find(read.child(read.child(index, 1, "columns"), 1, "columns"), "data");
  if (names == nullptr) refuse("columns", "no names", "an Index of names");
  names_ = read.texts(*names);
}

/// `places` in the table: slice(first, end, step), or an array of numbers.
void DataFrame::add_block(const PickleValue& values, const PickleValue& places) {
  const Reader read(*pickle_);
  PickledArray block = read.array(values);
  if (block.shape.size() == 1) block.shape.insert(block.shape.begin(), 1);
  std::vector<double> at;
  if (pickle_->is_of(places, "slice")) {
    const PickleValue& ends = read.child(places, 1, "slice");
    const std::int64_t first = read.integer(read.child(ends, 0, "slice"), "slice");
    const std::int64_t step = read.integer(read.child(ends, 2, "slice"), "slice");
    if (block.shape[0] > names_.size() || std::abs(step) > std::int64_t{1} << 32U ||
        std::abs(first) > std::int64_t{1} << 32U)
      refuse("slice", "beyond the columns", fmt::format("at most {}", names_.size()));
    for (std::size_t i = 0; i < block.shape[0]; ++i)
      at.push_back(static_cast<double>(first + static_cast<std::int64_t>(i) * step));
  } else {
    const PickledArray numbers = read.array(places);
    const ReadNumber number = reader_of(numbers.kind, numbers.bytes);
    if (number == nullptr || numbers.shape.size() != 1 || numbers.shape[0] != block.shape[0])
      refuse("places of columns", "another array", fmt::format("{} whole numbers", block.shape[0]));
    for (std::size_t i = 0; i < numbers.shape[0]; ++i)
      at.push_back(number(numbers.data.data() + i * numbers.bytes));
  }
  if (!blocks_.empty() && block.shape[1] != rows_)
    refuse("rows", fmt::format("{} and {}", rows_, block.shape[1]), "as many in each column");
  rows_ = block.shape[1];
  for (std::size_t row = 0; row < at.size(); ++row) {
    if (!(at[row] >= 0.0 && at[row] < static_cast<double>(names_.size())))
      refuse("places of columns", fmt::format("{}", at[row]), fmt::format("below {}", names_.size()));
    const std::string& name = names_[static_cast<std::size_t>(at[row])];
    if (!columns_.try_emplace(name, Column{blocks_.size(), row}).second)
      refuse("columns", '"' + name + "\" twice", "each once");
  }
  blocks_.push_back(std::move(block));
}

const PickledArray& DataFrame::block_of(const std::string& column, std::size_t& row) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) refuse("columns", "no \"" + column + '"', "one of that name");
  row = found->second.row;
  return blocks_[found->second.block];
}

std::vector<double> DataFrame::numbers(const std::string& column) const {
  std::size_t row = 0;
  const PickledArray& block = block_of(column, row);
  const ReadNumber number = reader_of(block.kind, block.bytes);
  if (number == nullptr) {
    refuse(
        "column \"" + column + '"', fmt::format("values of type {}{}", block.kind, block.bytes), "numbers");
  }
  std::vector<double> out(rows_);
  const std::size_t stride = block.is_column_major ? block.shape[0] : 1;
  const std::size_t first = block.is_column_major ? row : row * rows_;
  for (std::size_t i = 0; i < rows_; ++i)
    out[i] = number(block.data.data() + (first + i * stride) * block.bytes);
  return out;
}

std::vector<std::string> DataFrame::texts(const std::string& column) const {
  std::size_t row = 0;
  const PickledArray& block = block_of(column, row);
  const auto refuse_kind = [&] { refuse("column \"" + column + '"', "values of another kind", "texts"); };
  if (block.kind != 'O') refuse_kind();
  std::vector<std::string> out;
  out.reserve(rows_);
  const std::size_t stride = block.is_column_major ? block.shape[0] : 1;
  const std::size_t first = block.is_column_major ? row : row * rows_;
  for (std::size_t i = 0; i < rows_; ++i) {
    const PickleValue& value = pickle_->at((*block.values)[first + i * stride]);
    const bool is_missing =
        value.kind == PickleKind::kNone || (value.kind == PickleKind::kFloat && std::isnan(value.number));
    if (!is_missing && value.kind != PickleKind::kText) refuse_kind();
    out.emplace_back(is_missing ? std::string_view{} : value.text);
  }
  return out;
}

}  // namespace simuli::pandaset
