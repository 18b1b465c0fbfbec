#pragma once
// What is asked for of a picture or a sweep, and what becomes of a frame.
#include <cstddef>
#include <optional>
#include <string>

#include "host/apps/serve/messages/shot_message.hpp"
#include "host/apps/serve/session/ego_masks.hpp"
#include "host/device/render/outputs/picture_bytes.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli::serve {

/// Of one picture: as large as the viewer's.
inline constexpr double kMostPixels = 4096.0 * 4096.0;
/// Of a request's pictures together.
inline constexpr double kMostPixelsTogether = 4.0 * kMostPixels;

/// The camera of a request with the picture's size: the scene's own where the message says nothing else of it
/// than get_available_cameras does, or its logical_id alone. Errors as camera_of(); Refusal{kInvalid} for
/// sizes that are not allowed.
[[nodiscard]] Camera requested_camera(const ServedScene& scene, const proto::RGBRenderRequest& request);

/// How a picture is to be handed over.
struct PictureCode {
  proto::ImageFormat format = proto::PNG;
  int quality = 95;  // of JPEG
  std::optional<EgoMaskId> ego_mask;
};
/// Refusal{kInvalid}, Refusal{kUnimplemented} for formats that are not written, Refusal{kNotFound} for a mask
/// that there is not.
[[nodiscard]] PictureCode picture_code(const proto::RGBRenderRequest& request, const EgoMasks& ego_masks);

/// Pictures without a mask are bytes when they leave the device.
[[nodiscard]] PixelOrder order_of(const PictureCode& code);
/// [3][height][width] as write_image() would round it.
[[nodiscard]] std::string planar_bytes(const Image& image);
/// `bytes` in order_of(code).
[[nodiscard]] std::string encoded(std::string bytes, int width, int height, const PictureCode& code);
[[nodiscard]] std::string encoded(const Image& image, const PictureCode& code);

/// Where the request names none: the protocol's types by their models here. Refusal{kInvalid}.
[[nodiscard]] std::string lidar_name(const proto::LidarSpec& spec);

/// Which rays return, by the request's filter; without one as LidarFrame has it. Refusal{kInvalid},
/// Refusal{kUnimplemented} for the filter by distance.
struct ReturnFilter {
  std::optional<double> most_drop;      // probability of a drop, at most
  std::optional<double> least_opacity;  // 1 less the light that goes on, at least
};
[[nodiscard]] ReturnFilter return_filter(const proto::LidarRenderRequest& request);

/// A sweep's returns in the axes of the LiDAR at the shot's end.
[[nodiscard]] LidarFrame take_sweep(const Frame& frame, const ReturnFilter& filter);
void print_points(const LidarModel& lidar,
                 const LidarFrame& frame,
                 const Shot& shot,
                 proto::LidarRenderReturn& reply);

}  // namespace simuli::serve
