#include "host/core/scene/appearance.hpp"

#include <cmath>
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

std::vector<float> ColorGrids::at(const std::string& camera, double time_s) const {
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
  const auto share = static_cast<float>(span_s > 0.0 ? (time_s - before->time_s) / span_s : 0.0);
  const std::size_t count = values_per_frame();
  const float* a = values.data() + static_cast<std::size_t>(before - frames.data()) * count;
  const float* b = values.data() + static_cast<std::size_t>(behind - frames.data()) * count;
  std::vector<float> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = a[i] + share * (b[i] - a[i]);
  return out;
}

}  // namespace simuli
