#include "optim/base/frames.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <utility>

#include "host/base/error.hpp"
#include "io/log/camera_mask.hpp"

namespace simuli {

Camera scaled_camera(const Camera& camera, double scale) {
  const bool allowed = scale > 0.0 && scale * std::max(camera.width, camera.height) <= kLargestSide_px;
  if (!allowed) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "image scale: found {}, allowed above 0, and up to {} pixels a side", scale, kLargestSide_px));
  }
  // A hair less, so that 0.1 * 1240 is 124 and not 125.
  const auto side = [scale](int px) { return std::max(1, static_cast<int>(std::ceil(px * scale - 1e-9))); };
  return camera.resized(side(camera.width), side(camera.height));
}

Image load_image(const Log& log, const ImageFrame& frame, const Camera& scaled) {
  const Camera& model = log.camera(frame.camera).model;
  const std::filesystem::path file = log.folder / frame.file;
  Image image = read_image(file);
  if (image.width != model.width || image.height != model.height) {
    throw_input_error(file.string(),
                      "size",
                      fmt::format("{} x {}", image.width, image.height),
                      fmt::format("{} x {} as camera {}", model.width, model.height, model.name));
  }
  const auto mask = log.hidden.find(frame.camera);
  const auto hidden_in = [&](Image picture) {
    if (mask != log.hidden.end()) hide(*mask->second, picture);
    return picture;
  };
  if (scaled.width == image.width && scaled.height == image.height) return hidden_in(std::move(image));
  if (scaled.width > image.width || scaled.height > image.height) {
    throw Error(ErrorKind::kUsage,
                fmt::format("image scale: found {} x {} px of a recorded {} x {}, allowed at most as many",
                            scaled.width,
                            scaled.height,
                            image.width,
                            image.height));
  }
  return hidden_in(resize_area(image, scaled.width, scaled.height));
}

Shot shot_of(const Log& log, const ImageFrame& frame) {
  const Pose& rig_from_camera = log.camera(frame.camera).rig_from_camera;
  return Shot::along(log.world_from_rig, rig_from_camera, frame.time_start_s, frame.time_end_s);
}

Shot shot_of(const Log& log, const SweepFrame& frame) {
  const Pose& rig_from_lidar = log.lidar(frame.lidar).rig_from_lidar;
  return Shot::along(log.world_from_rig, rig_from_lidar, frame.time_start_s, frame.time_end_s);
}

View view_of(const Log& log, const Scene& scene, const ImageFrame& frame) {
  return view_of(scene, shot_of(log, frame), SetKind::kCamera);
}

View view_of(const Log& log, const Scene& scene, const SweepFrame& frame) {
  return view_of(scene, shot_of(log, frame), SetKind::kLidar);
}

std::vector<float> planar(const Image& image) {
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  const auto channels = static_cast<std::size_t>(image.channels);
  std::vector<float> out(image.data.size());
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t i = 0; i < pixels; ++i) out[c * pixels + i] = image.data[i * channels + c];
  }
  return out;
}

}  // namespace simuli
