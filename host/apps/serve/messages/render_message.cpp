#include "host/apps/serve/messages/render_message.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <utility>
#include <variant>
#include <vector>

#include "host/apps/serve/session/refusal.hpp"
#include "host/device/render/scene/readings.hpp"
#include "io/picture/image.hpp"

namespace simuli::serve {
namespace {

static_assert(std::endian::native == std::endian::little, "buffers of replies are little-endian");

Camera camera_before_size(const ServedScene& scene, const proto::CameraSpec& spec) {
  const Sensor* const own = scene.find_camera(spec.logical_id());
  if (own == nullptr) return camera_of(spec);
  const bool has_lens = spec.camera_param_case() != proto::CameraSpec::CAMERA_PARAM_NOT_SET;
  const bool is_own = has_lens && spec.SerializeAsString() == spec_of(own->camera()).SerializeAsString();
  if (is_own) return own->camera();
  if (has_lens || spec.has_bivariate_windshield_model_param()) return camera_of(spec);
  return own->camera();
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::span<unsigned char> as_bytes(std::string& text, std::size_t first, std::size_t count) {
  return {reinterpret_cast<unsigned char*>(text.data()) + first, count};
}

ImageCode image_code(proto::ImageFormat format) {
  if (format == proto::PNG) return ImageCode::kPng;
  return format == proto::JPEG ? ImageCode::kJpeg : ImageCode::kJpeg2000;
}

double probability(float value, const char* field) {
  if (!(value >= 0.0F && value <= 1.0F)) refuse(field, fmt::format("{}", value), "0 to 1");
  return static_cast<double>(value);
}

}  // namespace

Camera requested_camera(const ServedScene& scene, const proto::RGBRenderRequest& request) {
  const double width = request.resolution_w(), height = request.resolution_h();
  if (width < 1.0 || height < 1.0 || width > kMostJpeg_px || height > kMostJpeg_px ||
      width * height > kMostPixels) {
    refuse("resolution",
           fmt::format("{:.0f} x {:.0f} px", width, height),
           fmt::format("1 to {} a side, {:.0f} pixels at most", kMostJpeg_px, kMostPixels));
  }
  const Camera camera = camera_before_size(scene, request.camera_intrinsics());
  const int columns = static_cast<int>(width), rows = static_cast<int>(height);
  return camera.width == columns && camera.height == rows ? camera : camera.resized(columns, rows);
}

PictureCode picture_code(const proto::RGBRenderRequest& request, const EgoMasks& ego_masks) {
  PictureCode code;
  code.format = request.image_format();
  const auto found = [&] { return fmt::format("{}", static_cast<int>(request.image_format())); };
  constexpr const char* kAllowed = "1 (PNG), 2 (JPEG), 3 (JPEG2000) or 4 (RGB_UINT8_PLANAR)";
  switch (request.image_format()) {
    case proto::PNG:
    case proto::JPEG:
    case proto::JPEG2000:
    case proto::RGB_UINT8_PLANAR:
      break;
    case proto::AVC:
    case proto::AV1:
      throw Refusal(RefusalKind::kUnimplemented,
                    fmt::format("image_format: found {}, allowed {}", found(), kAllowed));
    default:
      refuse("image_format", found(), kAllowed);
  }
  const float quality = request.image_quality();
  if (!(quality >= 0.0F && quality <= 100.0F)) {
    refuse("image_quality", fmt::format("{}", quality), "1 to 100, or 0 for 95");
  }
  if (quality > 0.0F) code.quality = std::max(1, static_cast<int>(std::lround(quality)));
  if (!request.insert_ego_mask()) return code;
  code.ego_mask = EgoMaskId{request.ego_mask_id().rig_config_id(), request.ego_mask_id().camera_logical_id()};
  ego_masks.need(*code.ego_mask);
  return code;
}

PixelOrder order_of(const PictureCode& code) {
  return code.format == proto::RGB_UINT8_PLANAR ? PixelOrder::kPlanar : PixelOrder::kInterleaved;
}

std::string planar_bytes(const Image& image) {
  const std::size_t pixels = image.data.size() / 3;
  std::string interleaved(image.data.size(), '\0');
  to_bytes(image.data, as_bytes(interleaved, 0, interleaved.size()));
  std::string bytes(image.data.size(), '\0');
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) bytes[c * pixels + i] = interleaved[3 * i + c];
  }
  return bytes;
}

std::string encoded(std::string bytes, int width, int height, const PictureCode& code) {
  if (code.format == proto::RGB_UINT8_PLANAR) return bytes;
  return encode_pixels(
      as_bytes(bytes, 0, bytes.size()), width, height, image_code(code.format), code.quality);
}

std::string encoded(const Image& image, const PictureCode& code) {
  if (code.format == proto::RGB_UINT8_PLANAR) return planar_bytes(image);
  return encode_image(image, image_code(code.format), code.quality);
}

std::string lidar_name(const proto::LidarSpec& spec) {
  switch (spec.lidar_type()) {
    case proto::PANDAR128:
      return "hesai_pandar128";
    case proto::AT128:
      return "ncore_hesai_at128";
    default:
      refuse(
          "lidar_type", fmt::format("{}", static_cast<int>(spec.lidar_type())), "0 (PANDAR128), 1 (AT128)");
  }
}

ReturnFilter return_filter(const proto::LidarRenderRequest& request) {
  const proto::LidarRenderFilter& filter = request.render_filter();
  if (filter.enable_distance_filter()) {
    throw Refusal(
        RefusalKind::kUnimplemented,
        "render_filter.enable_distance_filter: found true, allowed false: what it does is not public");
  }
  ReturnFilter out;
  if (filter.has_raydrop_threshold()) {
    out.most_drop = probability(filter.raydrop_threshold(), "render_filter.raydrop_threshold");
  }
  if (filter.has_opacity_threshold()) {
    out.least_opacity = probability(filter.opacity_threshold(), "render_filter.opacity_threshold");
  }
  return out;
}

LidarFrame take_sweep(const Frame& frame, const ReturnFilter& filter) {
  if (!filter.most_drop && !filter.least_opacity) return frame.lidar();
  // Frames drop rays with a probability above a half; this maps the filter's limit to a half.
  constexpr float kSurely = 100.0F;
  RayResults results = frame.results();
  for (std::size_t i = 0; i < results.rays; ++i) {
    float& logit = results.drop_logit[i];
    if (filter.most_drop) {
      const bool returns = static_cast<double>(results.drop_probability(i)) <= *filter.most_drop;
      logit = returns ? -kSurely : kSurely;
    }
    if (filter.least_opacity && 1.0 - static_cast<double>(results.transmittance[i]) < *filter.least_opacity) {
      logit = kSurely;
    }
  }
  return lidar_frame(frame.sensor().lidar(), frame.sensor().rays(), results);
}

void print_points(const LidarModel& lidar,
                  const LidarFrame& frame,
                  const Shot& shot,
                  proto::LidarRenderReturn& reply) {
  const std::vector<Eigen::Vector3d> ends = points_of(lidar, frame, shot, PointFrame::kWorld);
  const Pose end_from_world = shot.world_from_sensor_end.inverse();
  const auto* const with_rows = std::get_if<Lidar>(&lidar);
  std::vector<float> places, intensities;
  std::vector<std::uint16_t> rings;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (!frame.is_return(i)) continue;
    for (const double value : end_from_world* ends[i]) places.push_back(static_cast<float>(value));
    intensities.push_back(frame.intensity[i]);
    if (with_rows != nullptr) {
      rings.push_back(static_cast<std::uint16_t>(i / static_cast<std::size_t>(with_rows->columns)));
    }
  }
  reply.set_num_points(static_cast<std::uint32_t>(intensities.size()));
  reply.set_point_xyzs_buffer(bytes_of(places));
  reply.set_point_intensities_buffer(bytes_of(intensities));
  reply.set_point_ring_ids_buffer(bytes_of(rings));
}

}  // namespace simuli::serve
