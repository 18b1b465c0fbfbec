#include "io/base/json_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host/base/error.hpp"

namespace simuli {
namespace {

/// A value on one line, cut to what a message can carry.
std::string shortened(const Json& value) {
  constexpr std::size_t kLongest = 60;
  std::string text = value.dump(-1, ' ', true);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

/// Escapes what would break the one line of a message.
std::string quoted(const std::string& key) { return Json(key).dump(-1, ' ', true); }

}  // namespace

JsonObject::JsonObject(std::string file, std::string path, const Json& value)
    : file_(std::move(file)), path_(std::move(path)), value_(value) {
  if (!value_.is_object()) {
    throw_input_error(file_, path_.empty() ? "root" : path_, shortened(value_), "an object {...}");
  }
}

std::string JsonObject::field(const std::string& key) const {
  return path_.empty() ? key : path_ + '.' + key;
}

const Json& JsonObject::get(const std::string& key) {
  asked_.insert(key);
  const auto it = value_.find(key);
  if (it != value_.end()) return *it;
  // The keys that are there show a misspelt name or a wrong unit at once.
  std::vector<std::string> present;
  for (const auto& [name, unused] : value_.items()) present.push_back(quoted(name));
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
  return value.get<std::string>();
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
  std::vector<std::set<std::string>> keys_of_open_objects;
  const auto refuse_repeated_keys = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys_of_open_objects.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_of_open_objects.pop_back();
    if (event == Json::parse_event_t::key &&
        !keys_of_open_objects.back().insert(value.get<std::string>()).second) {
      throw_input_error(file, quoted(value.get<std::string>()), "the key twice in one object", "once");
    }
    return true;
  };
  try {
    return Json::parse(text, refuse_repeated_keys);
  } catch (const Json::exception& error) {
    throw_input_error(file, "JSON", error.what(), "well-formed JSON");
  }
}

}  // namespace simuli
