#include "host/device/render/outputs/cloud.hpp"

#include <algorithm>
#include <variant>
#include <vector>

namespace simuli {

PointCloud point_cloud(const Frame& of, const CloudOptions& options) {
  const LidarFrame frame = of.lidar();
  const std::vector<Eigen::Vector3d> points = of.points(options.frame);
  const bool has_rows = std::holds_alternative<Lidar>(of.sensor().lidar());
  PointCloud cloud;
  const auto add = [&cloud](const char* name, ColumnType type) {
    cloud.columns.emplace_back(name);
    cloud.types.push_back(type);
  };
  for (const char* name : {"x", "y", "z"}) add(name, options.coordinates);
  for (const char* name : {"intensity", "range", "drop"}) add(name, ColumnType::kFloat);
  if (has_rows) add("ring", ColumnType::kUint16);
  add("time", ColumnType::kFloat);
  if (options.actors) add("actor", ColumnType::kUint16);
  const bool has_classes = options.actors && !options.classes.empty();
  if (has_classes) add("class", ColumnType::kUint16);
  if (!options.support.empty()) add("support", ColumnType::kFloat);
  const std::vector<std::uint32_t> actors = options.actors ? of.actors() : std::vector<std::uint32_t>{};
  cloud.values.resize(frame.returns(), static_cast<Eigen::Index>(cloud.columns.size()));
  const double duration_s = of.shot().time_end_s - of.shot().time_start_s;
  const auto columns = static_cast<std::size_t>(frame.rays.columns);
  double* to = cloud.values.data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!frame.is_return(i)) continue;
    to = std::copy(points[i].begin(), points[i].end(), to);
    for (const float value : {frame.intensity[i], frame.range[i], frame.drop[i]}) *to++ = value;
    if (has_rows) *to++ = static_cast<double>(i / columns);
    *to++ = static_cast<double>(frame.rays.time_fraction[i]) * duration_s;
    if (options.actors) *to++ = actors[i];
    if (has_classes) *to++ = actors[i] == 0 ? 0.0 : options.classes[actors[i] - 1];
    if (!options.support.empty()) *to++ = static_cast<double>(options.support[i]);
  }
  return cloud;
}

ColumnType coordinates_to_a_millimetre(double farthest_m) {
  constexpr double kFarthestFloat_m = 8192.0;  // float spacing there is a millimetre
  return farthest_m <= kFarthestFloat_m ? ColumnType::kFloat : ColumnType::kDouble;
}

}  // namespace simuli
