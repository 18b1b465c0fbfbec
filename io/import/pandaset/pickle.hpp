#pragma once
// Python's pickles as data: a tree of values without execution. For io/import/pandaset/*.cpp and tests.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace simuli::pandaset {

enum class PickleKind { kNone, kBool, kInteger, kFloat, kText, kBytes, kList, kTuple, kDict, kGlobal, kCall };

/// One value; its views refer to its Pickle.
struct PickleValue {
  PickleKind kind = PickleKind::kNone;
  std::int64_t integer = 0;  // kInteger, kBool
  double number = 0.0;       // kFloat
  std::string_view text;     // kText, kBytes; kGlobal: "module.name"
  /// kList, kTuple: the items; kDict: alternating keys and values; kCall: the callable, its arguments, and, if
  /// present, the state.
  std::vector<std::uint32_t> children;
};

/// A pickle of protocol 2 to 5 as pandas writes its tables: NumPy's arrays and pandas' classes are stored as
/// calls (callable, arguments, state), which are never executed. Refuses other classes and functions by name.
class Pickle {
 public:
  /// Throws Error{kInput} naming `file` and the byte for damaged or refused content, and for more than
  /// kMostValues.
  Pickle(std::string bytes, std::string file);
  Pickle(const Pickle&) = delete;
  Pickle& operator=(const Pickle&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const PickleValue& root() const { return values_[root_]; }
  [[nodiscard]] const PickleValue& at(std::uint32_t index) const { return values_[index]; }
  /// Returns the value under a text key of a dict; null without the key, and for other values.
  [[nodiscard]] const PickleValue* find(const PickleValue& dict, std::string_view key) const;
  /// Whether a value is a call of the named global, or the global itself.
  [[nodiscard]] bool is_of(const PickleValue& value, std::string_view global) const;

  static constexpr std::size_t kMostValues = std::size_t{1} << 22U;

 private:
  friend class PickleMachine;
  std::string bytes_, file_;
  std::deque<std::string> decoded_;  // bytes that the file contains as text
  std::vector<PickleValue> values_;
  std::uint32_t root_ = 0;
};

}  // namespace simuli::pandaset
