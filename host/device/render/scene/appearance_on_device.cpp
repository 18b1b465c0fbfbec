#include "host/device/render/scene/appearance_on_device.hpp"

#include <utility>

namespace simuli {

AppearanceOnDevice::AppearanceOnDevice(const Device& device, const Scene& scene, Precision precision)
    : device_(device), scene_(scene), precision_(precision) {
  if (scene.environment.empty()) return;
  environment_ = std::make_unique<EnvironmentBuffers>(device, scene.environment, precision);
}

Pass AppearanceOnDevice::graded(Pass pass, const std::string& camera, double time_s) {
  const ColorGrids& all = scene_.color_grids;
  if (all.empty() || camera.empty()) return pass;
  ColorGrids one = ColorGrids::identity(all.size_x, all.size_y, all.size_z, {});
  one.values = all.at(camera, time_s);
  if (one.values.empty()) return pass;
  pass.grade(ColorGridBuffers(device_, one, precision_), 0);
  return pass;
}

}  // namespace simuli
