#include "host/core/sensors/ray_list.hpp"

#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/core/base/error.hpp"

namespace simuli {

Eigen::Vector3d RayList::direction(std::size_t ray) const {
  return Lidar::direction(azimuth[ray], elevation[ray]);
}

Eigen::Vector3d RayList::ray_origin(std::size_t ray) const {
  return origin.empty() ? Eigen::Vector3d(0.0, 0.0, 0.0) : origin[ray];
}

void validate(const RayList& list, const std::string& file) {
  const std::string prefix = "ray list " + list.name + ": ";
  const auto refuse = [&](const std::string& field, const std::string& found, const std::string& allowed) {
    throw_input_error(file, prefix + field, found, allowed);
  };
  const std::size_t count = list.ray_count();
  if (count < 1 || count > std::size_t{1} << 24U)
    refuse("azimuth_rad", std::to_string(count) + " rays", "1 to 2^24");
  const auto need_count = [&](const char* field, std::size_t found) {
    if (found != count) refuse(field, fmt::format("{} rays", found), fmt::format("{} as azimuths", count));
  };
  need_count("elevation_rad", list.elevation.size());
  need_count("time_fraction", list.time_fraction.size());
  if (!list.origin.empty()) need_count("origin_m", list.origin.size());

  const auto need = [&](const char* field, double found, double low, double high) {
    if (!(found >= low && found <= high)) {
      refuse(field, fmt::format("{}", found), fmt::format("{} to {}", low, high));
    }
  };
  const auto need_each = [&](const char* field, const std::vector<double>& values, double low, double high) {
    for (std::size_t i = 0; i < count; ++i) {
      if (!(values[i] >= low && values[i] <= high))
        need(fmt::format("{}[{}]", field, i).c_str(), values[i], low, high);
    }
  };
  need_each("azimuth_rad", list.azimuth, -4.0 * std::numbers::pi, 4.0 * std::numbers::pi);
  need_each("elevation_rad", list.elevation, -std::numbers::pi / 2, std::numbers::pi / 2);
  need_each("time_fraction", list.time_fraction, -1.0, 2.0);
  for (std::size_t i = 0; i < list.origin.size(); ++i) {
    if (!(list.origin[i].cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= 10.0)) {
      refuse(fmt::format("origin_m[{}]", i), "a value beyond 10 or NaN", "-10 to 10");
    }
  }
  if (!(list.sweep_s > 0.0 && list.sweep_s <= kLongestSweep_s)) {
    refuse("sweep_s", fmt::format("{}", list.sweep_s), "above 0, at most 1000");
  }
  need("range_min_m", list.range_min, 0.0, 1e6);
  if (!(list.range_max > list.range_min && list.range_max <= 1e6)) {
    refuse("range_max_m", fmt::format("{}", list.range_max), "above range_min_m, at most 1e6");
  }
  if (!(list.beam_divergence >= 0.0 && list.beam_divergence < 0.5)) {
    refuse("beam_divergence_rad", fmt::format("{}", list.beam_divergence), "0 to 0.5");
  }
  need("divergence_variance", list.divergence_variance, 0.0, 10.0);
}

}  // namespace simuli
