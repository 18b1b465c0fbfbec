#include "io/import/pandaset/pickle.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli::pandaset {
namespace {

/// Names in pickled tables of pandas 1 to 3 and NumPy 1 and 2.
constexpr std::array<std::string_view, 30> kGlobals{
    "_codecs.encode",
    "builtins.slice",
    "__builtin__.slice",
    "numpy.dtype",
    "numpy.ndarray",
    "numpy.core.multiarray._reconstruct",
    "numpy._core.multiarray._reconstruct",
    "numpy.core.multiarray.scalar",
    "numpy._core.multiarray.scalar",
    "numpy.core.numeric._frombuffer",
    "numpy._core.numeric._frombuffer",
    "pandas.DataFrame",
    "pandas.core.frame.DataFrame",
    "pandas.core.internals.managers.BlockManager",
    "pandas.core.internals.blocks.new_block",
    "pandas._libs.internals._unpickle_block",
    "pandas._libs.internals.BlockManager",
    "pandas._libs.arrays.__pyx_unpickle_NDArrayBacked",
    "pandas.Index",
    "pandas.RangeIndex",
    "pandas.core.indexes.base.Index",
    "pandas.core.indexes.base._new_Index",
    "pandas.core.indexes.range.RangeIndex",
    "pandas.core.indexes.numeric.Int64Index",
    "pandas.core.indexes.numeric.Float64Index",
    "pandas.StringDtype",
    "pandas.core.arrays.string_.StringDtype",
    "pandas.arrays.StringArray",
    "pandas.core.arrays.string_.StringArray",
    "pandas.core.arrays.string_.StringArrayNumpySemantics",
};

}  // namespace

/// Python's pickle stack machine without the creation of objects.
class PickleMachine {
 public:
  explicit PickleMachine(Pickle& pickle) : to_(pickle), bytes_(pickle.bytes_) {}

  void run() {
    while (true) {
      start_ = at_;
      const auto code = static_cast<unsigned char>(take(1)[0]);
      if (code == '.') break;
      step(code);
    }
    if (stack_.size() != 1 || !marks_.empty()) refuse("end", "another number of values than one", "one");
    to_.root_ = stack_.back();
  }

 private:
  using Index = std::uint32_t;

  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(to_.file_, fmt::format("pickle, byte {}: {}", start_, field), found, allowed);
  }

  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_) refuse("content", "cut short", "a whole pickle");
    const std::string_view part = bytes_.substr(at_, count);
    at_ += count;
    return part;
  }

  /// Reads a little-endian number of `count` bytes.
  std::uint64_t number(std::size_t count) {
    std::uint64_t value = 0;
    const std::string_view part = take(count);
    for (std::size_t i = count; i-- > 0;) value = value << 8U | static_cast<unsigned char>(part[i]);
    return value;
  }

  Index make(PickleValue value) {
    if (to_.values_.size() >= Pickle::kMostValues)
      refuse("values", "more", fmt::format("at most {}", Pickle::kMostValues));
    to_.values_.push_back(std::move(value));
    return static_cast<Index>(to_.values_.size() - 1);
  }
  void push(PickleValue value) { stack_.push_back(make(std::move(value))); }
  void push_integer(std::int64_t value) { push({PickleKind::kInteger, value, 0.0, {}, {}}); }
  void push_text(PickleKind kind, std::string_view text) { push({kind, 0, 0.0, text, {}}); }

  /// Returns the number of values above the last mark.
  [[nodiscard]] std::size_t above_mark() const {
    return stack_.size() - (marks_.empty() ? 0 : marks_.back());
  }
  Index pop() {
    if (above_mark() == 0) refuse("stack", "no value where one is needed", "one");
    const Index top = stack_.back();
    stack_.pop_back();
    return top;
  }
  std::vector<Index> pop_many(std::size_t count) {
    if (above_mark() < count) refuse("stack", "too few values", fmt::format("{}", count));
    std::vector<Index> out(stack_.end() - static_cast<std::ptrdiff_t>(count), stack_.end());
    stack_.resize(stack_.size() - count);
    return out;
  }
  std::vector<Index> pop_to_mark() {
    if (marks_.empty()) refuse("stack", "no mark", "one");
    std::vector<Index> out = pop_many(above_mark());
    marks_.pop_back();
    return out;
  }

  PickleValue& top(PickleKind kind, const char* what) {
    if (above_mark() == 0 || to_.values_[stack_.back()].kind != kind)
      refuse("target", "another value", fmt::format("a {}", what));
    return to_.values_[stack_.back()];
  }
  void append(const std::vector<Index>& items, PickleKind kind, const char* what) {
    if (kind == PickleKind::kDict && items.size() % 2 != 0) refuse("items", "a key without a value", "pairs");
    std::vector<Index>& children = top(kind, what).children;
    children.insert(children.end(), items.begin(), items.end());
  }

  void remember(std::uint64_t key) {
    if (above_mark() == 0) refuse("memo", "nothing to keep", "a value");
    memo_[key] = stack_.back();
  }
  void recall(std::uint64_t key) {
    const auto found = memo_.find(key);
    if (found == memo_.end())
      refuse("memo", fmt::format("{}, which is not there", key), "a value kept before");
    stack_.push_back(found->second);
  }

  void push_global(std::string_view module, std::string_view name) {
    std::string full = fmt::format("{}.{}", module, name);
    const auto known = std::find(kGlobals.begin(), kGlobals.end(), full);
    if (known == kGlobals.end()) {
      constexpr std::size_t kShown = 100;
      refuse("class or function",
             '"' + full.substr(0, kShown) + '"',
             "what tables of pandas are made of (DataFrame of NumPy's numbers and of text)");
    }
    push_text(PickleKind::kGlobal, *known);
  }

  std::string_view line() {
    const std::size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) refuse("content", "cut short", "a whole pickle");
    const std::string_view text = take(end - at_);
    (void)take(1);
    return text;
  }

  /// Decodes bytes that protocol 2 writes as text: each character is a number below 256.
  std::string_view latin_bytes(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const auto first = static_cast<unsigned char>(text[i]);
      if (first < 0x80U) {
        out.push_back(text[i]);
        continue;
      }
      const unsigned char second = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
      if ((first != 0xc2U && first != 0xc3U) || (second & 0xc0U) != 0x80U)
        refuse("text", "no latin1", "bytes as latin1");
      out.push_back(static_cast<char>((first & 3U) << 6U | (second & 0x3fU)));
      ++i;
    }
    return to_.decoded_.emplace_back(std::move(out));
  }

  /// Records a call; a call of _codecs.encode becomes the bytes that it creates.
  void call(Index what, Index arguments) {
    const PickleValue& callee = to_.values_[what];
    const PickleValue& given = to_.values_[arguments];
    if (callee.kind != PickleKind::kGlobal || given.kind != PickleKind::kTuple)
      refuse("call", "of no class or function", "of one, with a tuple");
    if (callee.text == "_codecs.encode") {
      const bool is_text = given.children.size() == 2 &&
                           to_.at(given.children[0]).kind == PickleKind::kText &&
                           to_.at(given.children[1]).text == "latin1";
      if (!is_text) refuse("_codecs.encode", "other arguments", "a text and latin1");
      return push_text(PickleKind::kBytes, latin_bytes(to_.at(given.children[0]).text));
    }
    push({PickleKind::kCall, 0, 0.0, {}, {what, arguments}});
  }

  void set_state() {
    const Index state = pop();
    PickleValue& object = top(PickleKind::kCall, "call");
    if (object.children.size() != 2) refuse("state", "a second one", "one");
    object.children.push_back(state);
  }

  void long_integer(std::uint64_t count) {
    constexpr std::uint64_t kMostBytes = 8;
    if (count > kMostBytes) refuse("integer", fmt::format("of {} bytes", count), "at most 8");
    if (count == 0) return push_integer(0);
    const unsigned shift = static_cast<unsigned>(8 * (kMostBytes - count));
    push_integer(static_cast<std::int64_t>(number(count) << shift) >> shift);
  }

  void tuple_of(std::size_t count) { push({PickleKind::kTuple, 0, 0.0, {}, pop_many(count)}); }

  void step(unsigned char code) {
    switch (code) {
      case 0x80: {  // PROTO
        const std::uint64_t protocol = number(1);
        if (protocol < 2 || protocol > 5) refuse("protocol", fmt::format("{}", protocol), "2 to 5");
        return;
      }
      case 0x95:
        return (void)take(8);  // FRAME: a hint for read-ahead
      case '(':
        return marks_.push_back(stack_.size());
      case '0':
        return (void)pop();
      case '1':
        return (void)pop_to_mark();
      case '2': {
        const Index again = pop();
        stack_.insert(stack_.end(), 2, again);
        return;
      }
      case 'N':
        return push({});
      case 0x88:
        return push({PickleKind::kBool, 1, 0.0, {}, {}});
      case 0x89:
        return push({PickleKind::kBool, 0, 0.0, {}, {}});
      case 'J':
        return push_integer(static_cast<std::int32_t>(number(4)));
      case 'K':
        return push_integer(static_cast<std::int64_t>(number(1)));
      case 'M':
        return push_integer(static_cast<std::int64_t>(number(2)));
      case 0x8a:
        return long_integer(number(1));
      case 0x8b:
        return long_integer(number(4));
      case 'G': {  // big endian
        std::uint64_t bits = 0;
        for (const char c : take(8)) bits = bits << 8U | static_cast<unsigned char>(c);
        return push({PickleKind::kFloat, 0, std::bit_cast<double>(bits), {}, {}});
      }
      case 'X':
        return push_text(PickleKind::kText, take(number(4)));
      case 0x8c:
        return push_text(PickleKind::kText, take(number(1)));
      case 0x8d:
        return push_text(PickleKind::kText, take(number(8)));
      case 'B':
        return push_text(PickleKind::kBytes, take(number(4)));
      case 'C':
        return push_text(PickleKind::kBytes, take(number(1)));
      case 0x8e:
      case 0x96:
        return push_text(PickleKind::kBytes, take(number(8)));
      case ']':
        return push({PickleKind::kList, 0, 0.0, {}, {}});
      case 'a':
        return append({pop()}, PickleKind::kList, "list");
      case 'e':
        return append(pop_to_mark(), PickleKind::kList, "list");
      case '}':
        return push({PickleKind::kDict, 0, 0.0, {}, {}});
      case 's':
        return append(pop_many(2), PickleKind::kDict, "dict");
      case 'u':
        return append(pop_to_mark(), PickleKind::kDict, "dict");
      case ')':
        return tuple_of(0);
      case 't':
        return push({PickleKind::kTuple, 0, 0.0, {}, pop_to_mark()});
      case 0x85:
      case 0x86:
      case 0x87:
        return tuple_of(code - 0x84U);
      case 'c': {
        const std::string_view module = line();
        return push_global(module, line());
      }
      case 0x93: {
        const std::vector<Index> names = pop_many(2);
        for (const Index name : names) {
          if (to_.at(name).kind != PickleKind::kText) refuse("class or function", "no name", "a text");
        }
        return push_global(to_.at(names[0]).text, to_.at(names[1]).text);
      }
      case 'R':
      case 0x81: {  // NEWOBJ
        const std::vector<Index> parts = pop_many(2);
        return call(parts[0], parts[1]);
      }
      case 'b':
        return set_state();
      case 'h':
        return recall(number(1));
      case 'j':
        return recall(number(4));
      case 'q':
        return remember(number(1));
      case 'r':
        return remember(number(4));
      case 0x94:
        return remember(memo_.size());
      default:
        refuse("operation",
               fmt::format("0x{:02x}", code),
               "those of protocol 2 to 5 that tables of pandas are made of");
    }
  }

  Pickle& to_;
  std::string_view bytes_;
  std::size_t at_ = 0, start_ = 0;  // offset of the next byte, and of the current operation
  std::vector<Index> stack_;
  std::vector<std::size_t> marks_;  // number of values below each
  std::unordered_map<std::uint64_t, Index> memo_;
};

Pickle::Pickle(std::string bytes, std::string file) : bytes_(std::move(bytes)), file_(std::move(file)) {
  PickleMachine(*this).run();
}

const PickleValue* Pickle::find(const PickleValue& dict, std::string_view key) const {
  if (dict.kind != PickleKind::kDict) return nullptr;
  for (std::size_t i = 0; i + 1 < dict.children.size(); i += 2) {
    const PickleValue& own = at(dict.children[i]);
    if (own.kind == PickleKind::kText && own.text == key) return &at(dict.children[i + 1]);
  }
  return nullptr;
}

bool Pickle::is_of(const PickleValue& value, std::string_view global) const {
  if (value.kind == PickleKind::kCall) return is_of(at(value.children[0]), global);
  if (value.kind != PickleKind::kGlobal || !value.text.ends_with(global)) return false;
  return value.text.size() == global.size() || value.text[value.text.size() - global.size() - 1] == '.';
}

}  // namespace simuli::pandaset
