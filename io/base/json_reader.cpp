#include "io/base/json_reader.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <iterator>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"

namespace simuli {
namespace {

/// Maximum nesting depth; deeper documents could exhaust the stack of recursive readers.
constexpr std::size_t kDeepest = 64;
/// Maximum length of quoted file content in a message.
constexpr std::size_t kLongest = 60;

std::string cut(std::string text) {
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

/// Returns text as a JSON string, shortened before it is escaped, because it may be the whole file.
std::string quoted(const std::string& text) {
  const Json shown(text.substr(0, kLongest + 1));
  return cut(shown.dump(-1, ' ', true, Json::error_handler_t::replace));
}

/// Appends the value on one line and stops at the displayed length, because values may be as large as files.
void append(std::string& out, const Json& value) {
  if (out.size() > kLongest) return;
  if (!value.is_structured()) {
    out += value.is_string() ? quoted(value.get_ref<const std::string&>()) : value.dump();
    return;
  }
  const bool is_object = value.is_object();
  out += is_object ? '{' : '[';
  bool first = true;
  for (auto it = value.begin(); it != value.end() && out.size() <= kLongest; ++it) {
    if (!std::exchange(first, false)) out += ',';
    if (is_object) out += quoted(it.key()) + ':';
    append(out, *it);
  }
  out += is_object ? '}' : ']';
}

std::string shortened(const Json& value) {
  std::string text;
  append(text, value);
  return cut(std::move(text));
}

/// Parses in linear time. nlohmann's own parser searches an object linearly for every key, and takes three
/// times as long for lists of poses.
class Parser {
 public:
  Parser(const std::string& text, const std::string& file)
      : file_(file), text_(text), at_(text.data()), end_(text.data() + text.size()) {
    if (text.starts_with("\xEF\xBB\xBF")) at_ += 3;
  }

  Json whole() {
    Json root = value();
    need_end();
    return root;
  }

  void each(const std::function<void(const Json&)>& use) {
    if (next() != '[') throw_input_error(file_, "root", shortened(whole()), "an array [{...}, ...]");
    elements(use);
    need_end();
  }

 private:
  /// Throws nlohmann's error message for the same text.
  [[noreturn]] void refuse() const {
    std::string what = fmt::format("a fault at byte {}", at_ - text_.data());
    try {
      const Json none = Json::parse(text_, [](int, Json::parse_event_t, Json&) { return false; });
    } catch (const Json::exception& error) {
      what = error.what();
      what.erase(0, what.find(' ') + 1);  // the library's name of the error
      // The message quotes the last token: an unterminated string is the rest of the file.
      constexpr std::size_t kMost = 200;
      if (what.size() > kMost) what = what.substr(0, kMost) + "...";
    }
    throw_input_error(file_, "JSON", what, "well-formed JSON");
  }

  void need_end() {
    next();
    if (at_ != end_) refuse();  // nlohmann would accept a NUL as the end
  }

  /// Returns the next character after white space; the text ends with a NUL.
  char next() {
    while (*at_ == ' ' || *at_ == '\n' || *at_ == '\t' || *at_ == '\r') ++at_;
    return *at_;
  }

  bool takes(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }

  Json value() {
    switch (next()) {
      case '{':
        return object();
      case '[':
        return array();
      case '"':
        return string();
      case 't':
        return word("true", true);
      case 'f':
        return word("false", false);
      case 'n':
        return word("null", nullptr);
      default:
        return number();
    }
  }

  Json word(std::string_view name, Json meant) {
    if (!std::string_view(at_, static_cast<std::size_t>(end_ - at_)).starts_with(name)) refuse();
    at_ += name.size();
    return meant;
  }

  const char* digits(const char* at) const {
    if (!(*at >= '0' && *at <= '9')) refuse();
    while (*at >= '0' && *at <= '9') ++at;
    return at;
  }

  Json number() {
    const char* const from = at_;
    const char* to = from + (*from == '-' ? 1 : 0);
    to = *to == '0' ? to + 1 : digits(to);
    const bool is_whole = *to != '.' && *to != 'e' && *to != 'E';
    if (*to == '.') to = digits(to + 1);
    if (*to == 'e' || *to == 'E') to = digits(to + (to[1] == '-' || to[1] == '+' ? 2 : 1));
    at_ = to;
    const auto read = [&](auto value) -> Json {
      if (std::from_chars(from, to, value).ec == std::errc()) return value;
      return whole_of(from);  // parsed as a double, or refused if out of range
    };
    if (!is_whole) return read(0.0);
    return *from == '-' ? read(std::int64_t{0}) : read(std::uint64_t{0});
  }

  std::string string() {
    const char* const from = at_++;
    bool is_plain = true;
    for (; *at_ != '"'; ++at_) {
      const auto c = static_cast<unsigned char>(*at_);
      if (c < ' ') refuse();
      is_plain = is_plain && c < 0x80 && c != '\\';
      if (c == '\\' && static_cast<unsigned char>(*++at_) < ' ') refuse();
    }
    ++at_;
    if (is_plain) return {from + 1, at_ - 1};
    return whole_of(from).get<std::string>();
  }

  /// Returns nlohmann's value of the text from `from` to the current position.
  Json whole_of(const char* from) const {
    Json read = Json::parse(from, at_, nullptr, false);
    if (read.is_discarded()) refuse();
    return read;
  }

  template <class Use>
  void elements(const Use& use) {
    enter();
    if (!takes(']')) {
      do use(value());
      while (takes(','));
      if (!takes(']')) refuse();
    }
    --depth_;
  }

  /// Collects values in one list until the size of their array is known, so that small arrays need one
  /// allocation.
  Json array() {
    const std::size_t first = values_.size();
    elements([this](Json element) { values_.push_back(std::move(element)); });
    const auto begin = values_.begin() + static_cast<std::ptrdiff_t>(first);
    Json::array_t elements(std::make_move_iterator(begin), std::make_move_iterator(values_.end()));
    values_.erase(begin, values_.end());
    return elements;
  }

  Json object() {
    enter();
    const std::size_t first = members_.size();
    if (!takes('}')) {
      do {
        if (next() != '"') refuse();
        std::string key = string();
        if (!takes(':')) refuse();
        Json held = value();
        members_.emplace_back(std::move(key), std::move(held));
      } while (takes(','));
      if (!takes('}')) refuse();
    }
    --depth_;
    const auto begin = members_.begin() + static_cast<std::ptrdiff_t>(first);
    Json::object_t object;
    object.reserve(members_.size() - first);
    for (auto member = begin; member != members_.end(); ++member) {
      object.emplace_back(std::move(member->first), std::move(member->second));
    }
    members_.erase(begin, members_.end());
    keys_.clear();
    for (const auto& entry : object) keys_.push_back(entry.first);
    std::sort(keys_.begin(), keys_.end());
    const auto twice = std::adjacent_find(keys_.begin(), keys_.end());
    if (twice != keys_.end()) {
      throw_input_error(file_, quoted(std::string(*twice)), "the key twice in one object", "once");
    }
    return object;
  }

  void enter() {
    ++at_;
    if (++depth_ <= kDeepest) return;
    throw_input_error(
        file_, "JSON", fmt::format("more than {} levels", kDeepest), "objects and arrays less deep");
  }

  const std::string& file_;
  const std::string& text_;
  const char* at_;
  const char* end_;
  std::size_t depth_ = 0;
  std::vector<Json> values_;
  std::vector<std::pair<std::string, Json>> members_;
  std::vector<std::string_view> keys_;
};

}  // namespace

JsonObject::JsonObject(std::string file, std::string path, const Json& value)
    : file_(std::move(file)), path_(std::move(path)), value_(value) {
  if (!value_.is_object()) {
    throw_input_error(file_, path_.empty() ? "root" : path_, shortened(value_), "an object {...}");
  }
}

JsonObject::JsonObject(const JsonObject& parent, const std::string& key, std::size_t index, const Json& value)
    : parent_(&parent), index_(index), path_(key), value_(value) {
  if (!value_.is_object()) throw_input_error(file(), path(), shortened(value_), "an object {...}");
}

std::string JsonObject::path() const {
  return parent_ == nullptr ? path_ : fmt::format("{}[{}]", parent_->field(path_), index_);
}

std::string JsonObject::field(const std::string& key) const {
  const std::string shown = key.size() > kLongest ? quoted(key) : key;
  const std::string own = path();
  return own.empty() ? shown : own + '.' + shown;
}

const Json& JsonObject::get(const std::string& key) {
  if (std::find(requested_.begin(), requested_.end(), key) == requested_.end()) requested_.push_back(key);
  const auto it = value_.find(key);
  if (it != value_.end()) return *it;
  // The existing keys reveal a misspelt name or a wrong unit.
  constexpr std::size_t kMaxShown = 32;
  std::vector<std::string> present;
  for (auto at = value_.begin(); at != value_.end() && present.size() < kMaxShown; ++at) {
    present.push_back(quoted(at.key()));
  }
  if (present.size() < value_.size()) present.push_back("...");
  throw_input_error(file(),
                    field(key),
                    present.empty() ? "no key at all"
                                    : fmt::format("no such key; the keys are {}", fmt::join(present, ", ")),
                    "this key (and no other spelling or unit)");
}

void JsonObject::refuse(const std::string& key, const std::string& allowed) const {
  throw_input_error(file(), field(key), shortened(value_.at(key)), allowed);
}

double JsonObject::number(const std::string& key, double minimum, double maximum) {
  const Json& value = get(key);
  if (!value.is_number()) refuse(key, "a number");
  const double number = value.get<double>();
  if (!(number >= minimum && number <= maximum)) {
    refuse(key, fmt::format("{} to {}", minimum, maximum));
  }
  return number;
}

std::int64_t JsonObject::integer(const std::string& key, std::int64_t minimum, std::int64_t maximum) {
  const Json& value = get(key);
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (value.is_number_integer() && (!value.is_number_unsigned() || value.get<std::uint64_t>() <= kLargest)) {
    const auto number = value.get<std::int64_t>();
    if (number >= minimum && number <= maximum) return number;
  }
  refuse(key, fmt::format("an integer from {} to {}", minimum, maximum));
}

std::string JsonObject::text(const std::string& key) {
  const Json& value = get(key);
  if (!value.is_string()) refuse(key, "a string");
  return on_one_line(value.get<std::string>());
}

bool JsonObject::boolean(const std::string& key) {
  const Json& value = get(key);
  if (!value.is_boolean()) refuse(key, "true or false");
  return value.get<bool>();
}

const Json& JsonObject::array(const std::string& key) {
  const Json& value = get(key);
  if (!value.is_array()) refuse(key, "an array [...]");
  return value;
}

std::vector<double> JsonObject::numbers(const std::string& key) {
  std::vector<double> out(array(key).size());
  read_numbers(key, out.data(), out.size());
  return out;
}

void JsonObject::read_numbers(const std::string& key, double* values, std::size_t count) {
  const Json& elements = array(key);
  const bool are_numbers =
      std::all_of(elements.begin(), elements.end(), [](const Json& element) { return element.is_number(); });
  if (!are_numbers) refuse(key, "an array of numbers");
  if (elements.size() != count) refuse(key, fmt::format("an array of {} numbers", count));
  for (const Json& element : elements) *values++ = element.get<double>();
}

void JsonObject::finish() const {
  if (ignores_others_) return;
  for (auto at = value_.begin(); at != value_.end(); ++at) {
    if (std::find(requested_.begin(), requested_.end(), at.key()) != requested_.end()) continue;
    const std::set<std::string> requested(requested_.begin(), requested_.end());
    throw_input_error(
        file(), field(at.key()), "an unknown key", fmt::format("{}", fmt::join(requested, ", ")));
  }
}

Json parse_json(const std::string& text, const std::string& file) { return Parser(text, file).whole(); }

void read_json_entries(const std::string& text,
                       const std::string& file,
                       const std::function<void(JsonObject&)>& read) {
  std::size_t count = 0;
  Parser(text, file).each([&](const Json& value) {
    JsonObject entry(file, fmt::format("[{}]", count++), value);
    entry.read_and_finish(read);
  });
}

}  // namespace simuli
