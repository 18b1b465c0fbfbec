#include "optim/base/frames.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/log/camera_mask.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli {

Camera scaled_camera(const Camera& camera, double scale) {
  const double longer_px = scale * std::max(camera.width, camera.height);
  if (!(longer_px >= 0.5 && longer_px <= kLargestSide_px)) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("image scale: found {}, allowed what leaves half a pixel, and up to {} pixels a side",
                    scale,
                    kLargestSide_px));
  }
  // Slightly reduced, so that 0.1 * 1240 gives 124 and not 125.
  const auto side = [scale](int px) { return std::max(1, static_cast<int>(std::ceil(px * scale - 1e-9))); };
  return camera.resized(side(camera.width), side(camera.height));
}

/// Reads the picture from its file at `scaled`'s size.
static Image read_scaled(const std::filesystem::path& file, const Camera& model, const Camera& scaled) {
  Image image = read_image(file, model.width, model.height, "camera " + model.name);
  if (scaled.width == image.width && scaled.height == image.height) return image;
  if (scaled.width > image.width || scaled.height > image.height) {
    throw Error(ErrorKind::kUsage,
                fmt::format("image scale: found {} x {} px of a recorded {} x {}, allowed at most as many",
                            scaled.width,
                            scaled.height,
                            image.width,
                            image.height));
  }
  return resize_area(image, scaled.width, scaled.height);
}

FrameFiles::Wish wish_of(const Log& log, const ImageFrame& frame, const Camera& scaled) {
  const std::filesystem::path file = log.folder / frame.file;
  return {
      fmt::format("{} {} {}", file.string(), scaled.width, scaled.height),
      [file, model = log.camera(frame.camera).model, scaled] { return read_scaled(file, model, scaled); }};
}

void expect(const Log& log, const std::vector<const ImageFrame*>& frames, double image_scale) {
  if (log.files == nullptr) return;
  std::vector<FrameFiles::Wish> wishes;
  for (const ImageFrame* frame : frames) {
    wishes.push_back(wish_of(log, *frame, scaled_camera(log.camera(frame->camera).model, image_scale)));
  }
  log.files->expect(std::move(wishes));
}

Image load_image(const Log& log, const ImageFrame& frame, const Camera& scaled) {
  const FrameFiles::Wish wish = wish_of(log, frame, scaled);
  Image image = std::get<Image>(log.files == nullptr ? wish.read() : *log.files->get(wish));
  const auto mask = log.hidden.find(frame.camera);
  if (mask != log.hidden.end()) hide(*mask->second, image);
  return image;
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
