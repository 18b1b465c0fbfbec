#include "host/cli/train_settings.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <type_traits>
#include <variant>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

using Target = std::variant<double*, int*, std::size_t*, bool*>;

struct Setting {
  std::string key;
  Target target;
};

std::vector<Setting> settings_of(InitOptions& init, TrainOptions& train) {
  std::vector<Setting> all = {
      {"init.voxel_m", &init.voxel_m},
      {"init.camera_sh_degree", &init.camera_sh_degree},
      {"init.lidar_sh_degree", &init.lidar_sh_degree},
      {"init.max_camera", &init.max_camera},
      {"init.max_lidar", &init.max_lidar},
      {"init.max_shell", &init.max_shell},
      {"init.shell_spacing_deg", &init.shell_spacing_deg},
      {"init.camera_scale", &init.camera_scale},
      {"init.lidar_scale", &init.lidar_scale},
      {"init.min_scale_m", &init.min_scale_m},
      {"init.max_scale_m", &init.max_scale_m},
      {"init.sweep_depth", &init.sweep_depth},
      {"init.sweep_cell_px", &init.sweep_cell_px},
      {"init.drop_moving", &init.drop_moving},
      {"init.environment_width", &init.environment_width},
      {"loss.colour_absolute", &train.image.absolute},
      {"loss.colour_squared", &train.image.squared},
      {"loss.ssim", &train.image.dissimilarity},
      {"loss.environment_variation", &train.look.environment_variation},
      {"loss.grid_variation", &train.look.grid_variation},
      {"loss.grid_drift", &train.look.grid_drift},
      {"camera.loss.scale", &train.camera_particles.scale},
      {"camera.loss.opacity", &train.camera_particles.opacity},
      {"camera.loss.entropy", &train.camera_particles.entropy},
      {"lidar.loss.scale", &train.lidar_particles.scale},
      {"lidar.loss.opacity", &train.lidar_particles.opacity},
      {"lidar.loss.entropy", &train.lidar_particles.entropy},
      {"color_grids", &train.look.color_grids},
      {"look.rate.environment", &train.look.environment_rate},
      {"look.rate.grid", &train.look.grid_rate},
      {"look.rate.final_share", &train.look.final_share},
      {"render.camera_compensation", &train.render.camera_compensation},
      {"render.lidar_compensation", &train.render.lidar_compensation},
      {"init.actors", &init.actors},
      {"init.actor_min_travel_m", &init.actor_min_travel_m},
      {"init.actor_voxel_m", &init.actor_voxel_m},
      {"init.actor_margin_m", &init.actor_margin_m},
      {"init.mirror_actors", &init.mirror_actors},
      {"actors.rate.shift_m", &train.actor_poses.shift_m},
      {"actors.rate.turn_rad", &train.actor_poses.turn_rad},
      {"actors.rate.final_share", &train.actor_poses.final_share},
      {"actors.margin_m", &train.actor_margin_m},
      {"loss.distance", &train.weights.distance},
      {"loss.intensity", &train.weights.intensity},
      {"loss.drop", &train.weights.drop},
      {"anchor.weight", &train.anchor.weight},
      {"anchor.neighbours", &train.anchor.neighbours},
      {"anchor.every", &train.anchor.every},
      {"anchor.choose_every", &train.anchor.choose_every},
      {"anchor.reach_m", &train.anchor.reach_m},
      {"densify.every", &train.densify.every},
      {"densify.first", &train.densify.first},
      {"densify.last_share", &train.densify.last_share},
      {"densify.growth", &train.densify.growth},
      {"densify.cap", &train.densify.cap},
      {"densify.noise", &train.densify.noise},
      {"lidar_every", &train.lidar_every},
      {"mask_moving", &train.mask_moving},
      {"cache_bytes", &train.cache_bytes},
      {"memory_bytes", &train.memory_bytes},
      {"poses.camera", &train.poses.camera},
      {"poses.lidar", &train.poses.lidar},
      {"poses.translation_m", &train.poses.translation_m},
      {"poses.rotation_rad", &train.poses.rotation_rad},
  };
  const auto add_rates = [&all](const std::string& set, LearningRates& rates) {
    all.push_back({set + ".rate.mean_m", &rates.mean_m});
    all.push_back({set + ".rate.mean_final_m", &rates.mean_final_m});
    all.push_back({set + ".rate.log_scale", &rates.log_scale});
    all.push_back({set + ".rate.rotation", &rates.rotation});
    all.push_back({set + ".rate.opacity", &rates.opacity});
    all.push_back({set + ".rate.sh", &rates.sh});
    all.push_back({set + ".rate.sh_rest", &rates.sh_rest});
    all.push_back({set + ".rate.final_share", &rates.final_share});
  };
  add_rates("camera", train.camera);
  add_rates("lidar", train.lidar);
  return all;
}

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

}  // namespace

void apply_settings(const std::vector<std::string>& settings, InitOptions& init, TrainOptions& train) {
  const std::vector<Setting> all = settings_of(init, train);
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
    std::visit(
        [&](auto* target) {
          using T = std::remove_pointer_t<decltype(target)>;
          T value{};
          if (!parse(text, value)) {
            throw Error(ErrorKind::kUsage,
                        fmt::format("--set {}: found \"{}\", allowed {}", key, text, kKind<T>));
          }
          *target = value;
        },
        known->target);
  }
}

std::vector<std::string> list_settings(const InitOptions& init, const TrainOptions& train) {
  InitOptions init_copy = init;
  TrainOptions train_copy = train;
  std::vector<std::string> lines;
  for (const Setting& s : settings_of(init_copy, train_copy)) {
    lines.push_back(std::visit([&](auto* value) { return fmt::format("{}={}", s.key, *value); }, s.target));
  }
  return lines;
}

}  // namespace simuli::cli
