#include "host/core/scene/appearance.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace simuli {

std::size_t ColorGrids::values_per_frame() const {
  return static_cast<std::size_t>(size_x) * static_cast<std::size_t>(size_y) *
         static_cast<std::size_t>(size_z) * kMatrix;
}

ColorGrids ColorGrids::identity(int size_x, int size_y, int size_z, std::vector<Frame> frames) {
  ColorGrids grids;
  grids.size_x = size_x;
  grids.size_y = size_y;
  grids.size_z = size_z;
  grids.frames = std::move(frames);
  grids.values.assign(grids.frames.size() * grids.values_per_frame(), 0.0F);
  for (std::size_t at = 0; at < grids.values.size(); at += kMatrix) {
    for (std::size_t row = 0; row < 3; ++row) grids.values[at + 5 * row] = 1.0F;
  }
  return grids;
}

std::vector<ColorGrids::Part> ColorGrids::between(const std::string& camera, double time_s) const {
  const Frame* before = nullptr;
  const Frame* behind = nullptr;
  for (const Frame& frame : frames) {
    if (frame.camera != camera) continue;
    if (frame.time_s <= time_s) {
      if (before == nullptr || frame.time_s > before->time_s) before = &frame;
    } else if (behind == nullptr || frame.time_s < behind->time_s) {
      behind = &frame;
    }
  }
  if (before == nullptr) before = behind;
  if (behind == nullptr) behind = before;
  if (before == nullptr) return {};
  const double span_s = behind->time_s - before->time_s;
  const double share = span_s > 0.0 ? (time_s - before->time_s) / span_s : 0.0;
  std::vector<Part> parts{{static_cast<std::size_t>(before - frames.data()), 1.0 - share}};
  if (share > 0.0) parts.push_back({static_cast<std::size_t>(behind - frames.data()), share});
  return parts;
}

std::vector<float> ColorGrids::at(const Camera& camera,
                                  const Eigen::Quaterniond& world_from_camera,
                                  double time_s) const {
  const std::size_t count = values_per_frame();
  const std::size_t column = static_cast<std::size_t>(size_z) * kMatrix;
  const std::vector<Part> own = between(camera.name, time_s);
  if (!own.empty()) {
    const float* a = values.data() + own.front().frame * count;
    const float* b = values.data() + own.back().frame * count;
    const float share = own.size() > 1 ? static_cast<float>(own.back().weight) : 0.0F;
    std::vector<float> out(count);
    for (std::size_t i = 0; i < count; ++i) out[i] = a[i] + share * (b[i] - a[i]);
    return out;
  }
  std::map<std::string, int> grids_of;
  for (const Frame& frame : frames) ++grids_of[frame.camera];
  std::vector<Part> parts;
  for (const auto& [name, number] : grids_of) {
    const auto model = std::find_if(
        cameras.begin(), cameras.end(), [&of = name](const Camera& known) { return known.name == of; });
    for (Part part : between(name, time_s)) {
      if (number > 1 && model != cameras.end()) part.model = &*model;
      parts.push_back(part);
    }
  }
  std::vector<double> mean(column, 0.0);
  const double each = static_cast<double>(column) / static_cast<double>(count * grids_of.size());
  for (const Part& part : parts) {
    const float* of = values.data() + part.frame * count;
    const double weight = part.weight * each;
    for (std::size_t i = 0; i < count; ++i) mean[i % column] += weight * static_cast<double>(of[i]);
  }
  std::vector<float> out;
  out.reserve(count);
  for (int y = 0; y < size_y; ++y) {
    for (int x = 0; x < size_x; ++x) {
      const Eigen::Vector2d pixel(camera.width * x / (size_x - 1.0), camera.height * y / (size_y - 1.0));
      const Eigen::Vector3d direction = world_from_camera * camera.unproject(pixel);
      std::vector<double> sum(column, 0.0);
      double seen = 0.0;
      for (const Part& part : parts) seen += add_towards(direction, part, sum) ? part.weight : 0.0;
      for (std::size_t i = 0; i < column; ++i) {
        out.push_back(static_cast<float>(seen > 0.0 ? sum[i] / seen : mean[i]));
      }
    }
  }
  return out;
}

bool ColorGrids::add_towards(const Eigen::Vector3d& direction_world,
                             const Part& part,
                             std::vector<double>& sum) const {
  if (part.model == nullptr) return false;
  Eigen::Vector2d pixel;
  if (!part.model->project(looks[part.frame].conjugate() * direction_world, pixel)) return false;
  constexpr double kBeyond = 0.5;  // of a cell: a vertex on the picture's border represents this much beyond it
  const Eigen::Array2d last(size_x - 1.0, size_y - 1.0);
  const Eigen::Array2d place = pixel.array() / Eigen::Array2d(part.model->width, part.model->height) * last;
  if (!(place >= -kBeyond).all() || !(place <= last + kBeyond).all()) return false;
  const Eigen::Array2d inside = place.max(0.0).min(last);
  const Eigen::Array2i cell = inside.cast<int>().min(Eigen::Array2i(size_x - 2, size_y - 2));
  const Eigen::Array2d far = inside - cell.cast<double>();
  for (int corner = 0; corner < 4; ++corner) {
    const int dx = corner % 2, dy = corner / 2;
    const double weight =
        part.weight * (dx == 1 ? far.x() : 1.0 - far.x()) * (dy == 1 ? far.y() : 1.0 - far.y());
    const auto vertex = static_cast<std::size_t>((cell.y() + dy) * size_x + cell.x() + dx);
    const float* of = values.data() + part.frame * values_per_frame() + vertex * sum.size();
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * static_cast<double>(of[i]);
  }
  return true;
}

}  // namespace simuli
