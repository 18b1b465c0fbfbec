// JSON, and inputs of several parts of which some are.
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string_view>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/json_reader.hpp"
#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

/// The value and everything in it.
void collect(Json& value, std::vector<Json*>& to) {
  to.push_back(&value);
  if (!value.is_structured()) return;
  for (Json& inner : value) collect(inner, to);
}

Json some_value(Choice& choice) {
  switch (choice.below(9)) {
    case 0:
      return nullptr;
    case 1:
      return choice.below(2) == 0;
    case 2:
      return "";
    case 3:
      return Json::array();
    case 4:
      return Json::object();
    case 5:
      return std::numeric_limits<std::int64_t>::min() + static_cast<std::int64_t>(choice.below(2));
    case 6:
      return std::numeric_limits<std::uint64_t>::max() - choice.below(2);
    case 7:
      return static_cast<std::int64_t>(choice.below(5)) - 2;
    default:
      return choice.edge();  // what isn't finite is written as null
  }
}

/// Another number of the same type.
void nudge(Json& value, Choice& choice) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    const double changes[] = {-number, number * (1.0 + 1e-15), number * 10.0, number + 1.0, choice.edge()};
    value = changes[choice.below(std::size(changes))];
  } else if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    const std::uint64_t changes[] = {number + 1, number - 1, number * 2, number ^ (1U << choice.below(32))};
    value = changes[choice.below(std::size(changes))];
  } else if (value.is_string()) {
    value = choice.change(value.get<std::string>());
  } else {
    value = some_value(choice);
  }
}

void change_list(Json& list, Choice& choice) {
  const std::size_t at = choice.below(list.size()), other = choice.below(list.size());
  switch (choice.below(4)) {
    case 0:
      list.erase(at);
      break;
    case 1:
      list.push_back(Json(list[at]));
      break;
    case 2:
      std::swap(list[at], list[other]);
      break;
    default:
      list[at] = Json(list[other]);
  }
}

void change_object(Json& object, Choice& choice) {
  const auto at = std::next(object.begin(), static_cast<std::ptrdiff_t>(choice.below(object.size())));
  const auto other = std::next(object.begin(), static_cast<std::ptrdiff_t>(choice.below(object.size())));
  const std::string key = at.key();
  switch (choice.below(4)) {
    case 0:
      object.erase(key);
      break;
    case 1:
      object[choice.change(key)] = Json(at.value());
      break;
    case 2:
      std::swap(at.value(), other.value());
      break;
    default:
      at.value() = Json(other.value());
  }
}

std::optional<std::string> mutated_part(const std::string& text, Choice& choice) {
  Json root;
  try {
    root = parse_json(text, "input");
  } catch (const Error&) {
    return std::nullopt;
  }
  std::vector<Json*> values;
  collect(root, values);
  Json& here = *values[choice.below(values.size())];
  switch (choice.below(6)) {
    case 0:
      here = some_value(choice);
      break;
    case 1:
      here = Json(*values[choice.below(values.size())]);
      break;
    default:
      if (here.is_array() && !here.empty()) {
        change_list(here, choice);
      } else if (here.is_object() && !here.empty()) {
        change_object(here, choice);
      } else {
        nudge(here, choice);
      }
  }
  return root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::optional<std::string> mutated_json(const std::string& text, Choice& choice) {
  constexpr std::string_view kBetween = kBetweenParts;
  std::vector<std::string> parts;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find(kBetween, at);
    parts.push_back(text.substr(at, end - at));
    if (end == std::string::npos) break;
    at = end + kBetween.size();
  }
  std::string& part = parts[choice.below(parts.size())];
  const std::optional<std::string> changed = mutated_part(part, choice);
  if (!changed && parts.size() == 1) return std::nullopt;
  part = changed ? *changed : mutated_numbers(part, sizeof(float), choice);
  std::string out = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) out += std::string(kBetween) + parts[i];
  return out;
}

}  // namespace simuli::test
