#include "host/core/base/fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"

namespace simuli {

bool Allowed::holds(double value) const {
  if (!std::isfinite(value)) return false;
  if (value == also) return true;
  if (even && std::fmod(value, 2.0) != 0.0) return false;
  return (above ? value > least : value >= least) && value <= most;
}

std::string Allowed::text() const {
  std::string text = std::isnan(also) ? "" : fmt::format("{}, or ", also);
  const bool has_least = std::isfinite(least), has_most = std::isfinite(most);
  if (!has_least && !has_most) {
    text += "any finite number";
  } else if (above) {
    text += fmt::format("above {}", least);
    if (has_most) text += fmt::format(", at most {}", most);
  } else if (has_least) {
    text += has_most ? fmt::format("{} to {}", least, most) : fmt::format("{} or more", least);
  } else {
    text += fmt::format("at most {}", most);
  }
  return even ? text + " and even" : text;
}

namespace {

/// Parses the complete text as one value; no value on failure.
template <class T>
std::optional<T> parsed(const std::string& text) {
  T value{};
  if constexpr (std::is_same_v<T, bool>) {
    if (text != "true" && text != "false") return std::nullopt;
    value = text == "true";
  } else {
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  }
  return value;
}

/// Parses names separated by commas; no value when one is empty. An empty text gives no names.
template <>
std::optional<std::vector<std::string>> parsed(const std::string& text) {
  std::vector<std::string> names;
  std::size_t at = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    if (end == at) return std::nullopt;
    names.push_back(text.substr(at, end - at));
    if (end == text.size()) break;
    at = end + 1;
  }
  return names;
}

bool may_be(bool /*unused*/, const Allowed& /*unused*/) { return true; }
bool may_be(const std::vector<std::string>& /*unused*/, const Allowed& /*unused*/) { return true; }
template <class Number>
bool may_be(Number value, const Allowed& range) {
  return range.holds(static_cast<double>(value));
}

bool set_text(const Field& field, const EnumValue& choice, const std::string& text) {
  const auto name = std::find(field.names.begin(), field.names.end(), text);
  if (name == field.names.end()) return false;
  choice.set(choice.at, static_cast<std::size_t>(name - field.names.begin()));
  return true;
}
template <class T>
bool set_text(const Field& field, T* target, const std::string& text) {
  const std::optional<T> value = parsed<T>(text);
  if (!value || !may_be(*value, field.range)) return false;
  *target = *value;
  return true;
}

bool is_sound(const Field& field, const EnumValue& choice) {
  return choice.get(choice.at) < field.names.size();
}
template <class T>
bool is_sound(const Field& field, const T* target) {
  return may_be(*target, field.range);
}

std::string text_of(const EnumValue& choice, const Field& field) {
  const std::size_t value = choice.get(choice.at);
  return value < field.names.size() ? field.names[value] : std::to_string(value);
}
template <class T>
std::string text_of(const T* target, const Field& /*unused*/) {
  return fmt::format("{}", *target);
}
std::string text_of(const std::vector<std::string>* names, const Field& /*unused*/) {
  return fmt::format("{}", fmt::join(*names, ","));
}

}  // namespace

std::string Field::text() const {
  return std::visit([this](const auto& target) { return text_of(target, *this); }, value);
}

std::string Field::allowed() const {
  if (std::holds_alternative<EnumValue>(value)) return fmt::format("{}", fmt::join(names, ", "));
  if (std::holds_alternative<bool*>(value)) return "true, false";
  if (std::holds_alternative<std::vector<std::string>*>(value)) return "names with commas between";
  const bool is_whole = !std::holds_alternative<double*>(value) && !range.even;
  return is_whole ? range.text() + " (whole)" : range.text();
}

bool Field::is_sound() const {
  return std::visit([this](const auto& target) { return simuli::is_sound(*this, target); }, value);
}

bool Field::set(const std::string& text) const {
  return std::visit([&](const auto& target) { return set_text(*this, target, text); }, value);
}

std::string Fields::current_key(const std::string& key) {
  // Logs, scenes and scripts of version 0.1 contain old keys (CHANGELOG.md).
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kRenamed{{
      {"actors.fill", "actors.inpaint"},
      {"beside.reach_m", "off_trajectory.reach_m"},
      {"beside.weight", "off_trajectory.weight"},
      {"init.off_path_m", "init.off_trajectory_m"},
      {"look.least_share", "appearance.least_share"},
      {"render.max_instances", "render.max_pairs"},
      {"stretch.length_m", "chunk.length_m"},
  }};
  for (const auto& [old_key, new_key] : kRenamed) {
    if (key == old_key) return std::string(new_key);
  }
  return key;
}

const Field* Fields::find(const std::string& key) const {
  const auto found =
      std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return f.key == key; });
  return found == fields_.end() ? nullptr : &*found;
}

std::string Fields::Fixed::allowed() const {
  const bool has_gradients = field.in_training != InTraining::kNoGradients;
  return usual + (has_gradients ? " in trainings" : " in trainings: nothing else has gradients");
}

std::string Fields::known_like(const std::string& key) const {
  std::vector<std::string> keys;
  for (const Field& field : fields_) keys.push_back(field.key);
  return fmt::format("{}", fmt::join(close_names(key, keys), ", "));
}

void Fields::apply(const std::vector<std::string>& settings, const std::string& where) {
  const auto refuse = [](const std::string& what, const std::string& found, const std::string& allowed) {
    throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", what, found, allowed));
  };
  std::set<std::string> seen;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    const std::string key = current_key(setting.substr(0, equals));
    const Field* const field = find(key);
    const auto fixed =
        std::find_if(fixed_.begin(), fixed_.end(), [&](const Fixed& one) { return one.field.key == key; });
    if (fixed != fixed_.end()) {
      const std::string text = equals == std::string::npos ? "" : setting.substr(equals + 1);
      if (text != fixed->usual) refuse(where + " " + key, text, fixed->allowed());
      continue;
    }
    if (field == nullptr) {
      const std::string close = known_like(key);
      refuse(where,
             fmt::format("no key \"{}\"", key),
             close.empty() ? "those that \"--set help\" lists" : close + " (\"--set help\" lists all)");
    }
    if (equals == std::string::npos) refuse(where, fmt::format("\"{}\"", setting), "KEY=VALUE");
    if (!seen.insert(key).second) refuse(where, key + " twice", "once");
    const std::string text = setting.substr(equals + 1);
    if (field->set(text)) continue;
    const bool is_number = parsed<double>(text).has_value();
    refuse(where + " " + key, is_number ? text : fmt::format("\"{}\"", text), field->allowed());
  }
}

std::vector<std::string> Fields::lines() const {
  std::vector<std::string> lines;
  for (const Field& field : fields_) lines.push_back(field.key + "=" + field.text());
  return lines;
}

void Fields::check() const {
  for (const Field& field : fields_) {
    if (field.is_sound()) continue;
    throw Error(ErrorKind::kUsage,
                fmt::format("{}: found {}, allowed {}", field.key, field.text(), field.allowed()));
  }
  for (const Fixed& one : fixed_) {
    if (one.field.text() == one.usual) continue;
    throw Error(ErrorKind::kUsage,
                fmt::format("{}: found {}, allowed {}", one.field.key, one.field.text(), one.allowed()));
  }
}

/// Wraps `text` to kColumns, indented by kIndent.
static std::string folded(const std::string& text) {
  constexpr std::size_t kColumns = 96, kIndent = 6;
  std::string lines, line(kIndent, ' ');
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (line.size() > kIndent && line.size() + 1 + word.size() > kColumns) {
      lines += line + '\n';
      line.assign(kIndent, ' ');
    }
    if (line.size() > kIndent) line += ' ';
    line += word;
  }
  return lines + line + '\n';
}

std::string Fields::help() const {
  std::vector<std::string> groups;  // in the order of their first fields
  for (const Field& field : fields_) {
    if (std::find(groups.begin(), groups.end(), field.group) == groups.end()) groups.push_back(field.group);
  }
  std::string text;
  for (const std::string& group : groups) {
    if (!text.empty()) text += '\n';
    if (!group.empty()) text += group + '\n';
    for (const Field& field : fields_) {
      if (field.group != group) continue;
      text += fmt::format("  {}={}  ({})\n", field.key, field.text(), field.allowed()) + folded(field.help);
    }
  }
  return text;
}

}  // namespace simuli
