#include "host/device/render/scene/appearance_on_device.hpp"

#include <utility>

namespace simuli {

AppearanceOnDevice::AppearanceOnDevice(const Device& device, const Scene& scene, Precision precision)
    : device_(device), scene_(scene), precision_(precision) {
  if (scene.environment.empty()) return;
  environment_ = std::make_unique<EnvironmentBuffers>(device, scene.environment, precision);
}

Pass AppearanceOnDevice::graded(Pass pass, const Camera* camera, const Shot& shot) {
  const ColorGrids& all = scene_.color_grids;
  if (all.empty() || camera == nullptr) return pass;
  ColorGrids one = ColorGrids::identity(all.size_x, all.size_y, all.size_z, {});
  one.values = all.at(*camera, shot.pose_at(0.5).rotation, shot.middle_s());
  pass.grade(ColorGridBuffers(device_, one, precision_), 0);
  return pass;
}

}  // namespace simuli
