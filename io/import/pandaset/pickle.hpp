#pragma once
// Python's pickles as data: a tree of values that runs nothing. For io/import/pandaset/*.cpp and tests.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace simuli::pandaset {

enum class PickleKind { kNone, kBool, kInteger, kFloat, kText, kBytes, kList, kTuple, kDict, kGlobal, kCall };

/// One value; views lead into its Pickle.
struct PickleValue {
  PickleKind kind = PickleKind::kNone;
  std::int64_t integer = 0;  // kInteger, kBool
  double number = 0.0;       // kFloat
  std::string_view text;     // kText, kBytes; kGlobal: "module.name"
  /// kList, kTuple: the items; kDict: keys and values in turns; kCall: what is called, its arguments, and, if
  /// there is one, the state that was set.
  std::vector<std::uint32_t> children;
};

/// A pickle of protocol 2 to 5 as pandas writes its tables: NumPy's arrays and pandas' own classes are calls
/// (what, arguments, state) that nobody makes. Any other class or function, and what these never need, is
/// refused by name.
class Pickle {
 public:
  /// Error{kInput} naming `file` and the byte for what is damaged, refused, or more than kMostValues.
  Pickle(std::string bytes, std::string file);
  Pickle(const Pickle&) = delete;
  Pickle& operator=(const Pickle&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const PickleValue& root() const { return values_[root_]; }
  [[nodiscard]] const PickleValue& at(std::uint32_t index) const { return values_[index]; }
  /// The value under a text key of a dict; null: none, or no dict.
  [[nodiscard]] const PickleValue* find(const PickleValue& dict, std::string_view key) const;
  /// Whether it is a call of the global of that name, or the global itself.
  [[nodiscard]] bool is_of(const PickleValue& value, std::string_view global) const;

  static constexpr std::size_t kMostValues = std::size_t{1} << 22U;

 private:
  friend class PickleMachine;
  std::string bytes_, file_;
  std::deque<std::string> decoded_;  // bytes that stood in the file as text
  std::vector<PickleValue> values_;
  std::uint32_t root_ = 0;
};

}  // namespace simuli::pandaset
