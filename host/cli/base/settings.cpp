#include "host/cli/base/settings.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <type_traits>
#include <utility>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

/// True when the whole text is one number of that type.
template <class T>
bool parse(const std::string& text, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = text == "true";
    return text == "true" || text == "false";
  } else {
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    return result.ec == std::errc{} && result.ptr == end;
  }
}

template <class T>
constexpr const char* kKind = "a number";
template <>
constexpr const char* kKind<int> = "an integer";
template <>
constexpr const char* kKind<std::size_t> = "an integer, 0 or more";
template <>
constexpr const char* kKind<bool> = "true or false";

[[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("--set {}: found \"{}\", allowed {}", key, found, allowed));
}

void set(const std::string& key, const std::string& text, const Choice& choice) {
  const auto name = std::find(choice.names.begin(), choice.names.end(), text);
  if (name == choice.names.end()) refuse(key, text, fmt::format("{}", fmt::join(choice.names, ", ")));
  choice.set(static_cast<std::size_t>(name - choice.names.begin()));
}

template <class T>
void set(const std::string& key, const std::string& text, T* target) {
  T value{};
  if (!parse(text, value)) refuse(key, text, kKind<T>);
  *target = value;
}

std::string text_of(const Choice& choice) { return choice.names[choice.get()]; }
template <class T>
std::string text_of(const T* target) {
  return fmt::format("{}", *target);
}

template <class Enum>
Choice choice_of(Enum& value, std::vector<std::string> names) {
  return {std::move(names),
          [&value] { return static_cast<std::size_t>(value); },
          [&value](std::size_t index) { value = static_cast<Enum>(index); }};
}

}  // namespace

void apply_settings(const std::vector<std::string>& settings, const std::vector<Setting>& all) {
  std::set<std::string> seen;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    const std::string key = setting.substr(0, equals);
    const auto known = std::find_if(all.begin(), all.end(), [&](const Setting& s) { return s.key == key; });
    if (known == all.end() || equals == std::string::npos) {
      std::vector<std::string> keys;
      for (const Setting& s : all) keys.push_back(s.key);
      throw Error(
          ErrorKind::kUsage,
          fmt::format(
              "--set: found \"{}\", allowed KEY=VALUE with the keys {}", setting, fmt::join(keys, ", ")));
    }
    if (!seen.insert(key).second) {
      throw Error(ErrorKind::kUsage, fmt::format("--set: found {} twice, allowed once", key));
    }
    const std::string text = setting.substr(equals + 1);
    std::visit([&](const auto& target) { set(key, text, target); }, known->target);
  }
}

std::vector<std::string> list_settings(const std::vector<Setting>& all) {
  std::vector<std::string> lines;
  for (const Setting& s : all) {
    const std::string value = std::visit([](const auto& target) { return text_of(target); }, s.target);
    lines.push_back(s.key + "=" + value);
  }
  return lines;
}

std::vector<Setting> render_settings(RenderOptions& options) {
  return {
      {"render.projection", choice_of(options.projection, {"unscented", "linearized", "monte_carlo"})},
      {"render.extent", choice_of(options.extent, {"unscented", "exact"})},
      {"render.order", choice_of(options.order, {"range", "per_ray"})},
      {"render.sh_direction", choice_of(options.sh_direction, {"particle", "ray"})},
      {"render.sh_degree", choice_of(options.sh_degree, {"0", "1", "2", "3", "auto"})},
      {"render.sh_error", &options.sh_error},
      {"render.sh_storage", choice_of(options.sh_storage, {"full", "half"})},
      {"render.math", choice_of(options.math, {"fast", "precise"})},
      {"render.precision", choice_of(options.precision, {"float", "double"})},
      {"render.shutter_iterations", &options.shutter_iterations},
      {"render.alpha_cut", &options.alpha_cut},
      {"render.transmittance_cut", &options.transmittance_cut},
      {"render.camera_filter_px2", &options.camera_filter_px2},
      {"render.camera_compensation", &options.camera_compensation},
      {"render.lidar_compensation", &options.lidar_compensation},
      {"render.culling", choice_of(options.culling, {"off", "auto", "always"})},
      {"render.lidar_tiles.elevation", &options.lidar_tiles.elevation},
      {"render.lidar_tiles.rays", &options.lidar_tiles.rays},
      {"render.max_instances", &options.max_instances},
  };
}

}  // namespace simuli::cli
