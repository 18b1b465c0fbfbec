#include "io/base/json_reader.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"

namespace simuli {
namespace {

/// Files are data and lists of it; what nests deeper is made to exhaust the stack of whoever walks through
/// it.
constexpr std::size_t kDeepest = 64;
/// Of a file's own text, what one line of a message can carry.
constexpr std::size_t kLongest = 60;

std::string cut(std::string text) {
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

/// Text as JSON, cut before it is written out: it may be the whole file.
std::string quoted(const std::string& text) {
  const Json shown(text.substr(0, kLongest + 1));
  return cut(shown.dump(-1, ' ', true, Json::error_handler_t::replace));
}

/// Appends the value on one line and stops where no more of it will be shown: values are as large as files.
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

/// Builds the value from the parser's events, each in constant time: nlohmann's own parser with a callback
/// looks through the whole parent behind every object, and its objects through their keys at every key.
class Builder final : public nlohmann::json_sax<Json> {
 public:
  Builder(const std::string& file, Json& root) : file_(file), root_(root) {}

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t& value) override { return add(std::move(value)); }
  bool key(string_t& name) override {
    open_.back()->get_ref<Json::object_t&>().emplace_back(std::move(name), nullptr);
    return true;
  }
  bool start_object(std::size_t) override { return open(Json::value_t::object); }
  bool start_array(std::size_t) override { return open(Json::value_t::array); }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool end_object() override {
    keys_.clear();
    for (const auto& entry : open_.back()->get_ref<const Json::object_t&>()) keys_.push_back(entry.first);
    std::sort(keys_.begin(), keys_.end());
    const auto twice = std::adjacent_find(keys_.begin(), keys_.end());
    if (twice != keys_.end()) {
      throw_input_error(file_, quoted(std::string(*twice)), "the key twice in one object", "once");
    }
    return end_array();
  }
  bool parse_error(std::size_t, const std::string&, const Json::exception& error) override {
    // It quotes what it read last: a string without an end is the rest of the file.
    constexpr std::size_t kMost = 200;
    std::string what(error.what());
    what.erase(0, what.starts_with('[') ? what.find(' ') + 1 : 0);  // its own name for the error
    if (what.size() > kMost) what = what.substr(0, kMost) + "...";
    throw_input_error(file_, "JSON", what, "well-formed JSON");
  }

 private:
  /// Puts a value where the innermost open one takes it; a parent does not grow while a child is open.
  Json& put(Json value) {
    if (open_.empty()) return root_ = std::move(value);
    if (open_.back()->is_array()) {
      auto& elements = open_.back()->get_ref<Json::array_t&>();
      elements.push_back(std::move(value));
      return elements.back();
    }
    return open_.back()->get_ref<Json::object_t&>().back().second = std::move(value);
  }
  bool add(Json value) {
    put(std::move(value));
    return true;
  }
  bool open(Json::value_t type) {
    if (open_.size() >= kDeepest) {
      throw_input_error(
          file_, "JSON", fmt::format("more than {} levels", kDeepest), "objects and arrays less deep");
    }
    open_.push_back(&put(type));
    return true;
  }

  const std::string& file_;
  Json& root_;
  std::vector<Json*> open_;
  std::vector<std::string_view> keys_;
};

}  // namespace

JsonObject::JsonObject(std::string file, std::string path, const Json& value)
    : file_(std::move(file)), path_(std::move(path)), value_(value) {
  if (!value_.is_object()) {
    throw_input_error(file_, path_.empty() ? "root" : path_, shortened(value_), "an object {...}");
  }
}

std::string JsonObject::field(const std::string& key) const {
  const std::string shown = key.size() > kLongest ? quoted(key) : key;
  return path_.empty() ? shown : path_ + '.' + shown;
}

const Json& JsonObject::get(const std::string& key) {
  asked_.insert(key);
  const auto it = value_.find(key);
  if (it != value_.end()) return *it;
  // The keys that are there show a misspelt name or a wrong unit at once.
  constexpr std::size_t kMostShown = 32;
  std::vector<std::string> present;
  for (auto at = value_.begin(); at != value_.end() && present.size() < kMostShown; ++at) {
    present.push_back(quoted(at.key()));
  }
  if (present.size() < value_.size()) present.push_back("...");
  throw_input_error(
      file_,
      field(key),
      present.empty() ? "no key at all" : fmt::format("no such key beside {}", fmt::join(present, ", ")),
      "this key (and no other spelling or unit)");
}

void JsonObject::refuse(const std::string& key, const std::string& allowed) const {
  throw_input_error(file_, field(key), shortened(value_.at(key)), allowed);
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
  const std::string allowed = fmt::format("an integer from {} to {}", minimum, maximum);
  if (!value.is_number_integer()) refuse(key, allowed);
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > kLargest) refuse(key, allowed);
  const auto number = value.get<std::int64_t>();
  if (number < minimum || number > maximum) refuse(key, allowed);
  return number;
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
  const Json& elements = array(key);
  std::vector<double> out;
  out.reserve(elements.size());
  for (const Json& element : elements) {
    if (!element.is_number()) refuse(key, "an array of numbers");
    out.push_back(element.get<double>());
  }
  return out;
}

std::vector<double> JsonObject::numbers_of_count(const std::string& key, std::size_t count) {
  std::vector<double> out = numbers(key);
  if (out.size() != count) refuse(key, fmt::format("an array of {} numbers", count));
  return out;
}

void JsonObject::finish() const {
  if (ignores_others_) return;
  for (const auto& [key, unused] : value_.items()) {
    if (asked_.contains(key)) continue;
    throw_input_error(file_, field(key), "an unknown key", fmt::format("{}", fmt::join(asked_, ", ")));
  }
}

Json parse_json(const std::string& text, const std::string& file) {
  Json root;
  Builder builder(file, root);
  Json::sax_parse(text, &builder);
  return root;
}

}  // namespace simuli
