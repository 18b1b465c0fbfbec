#pragma once
// Requests for pictures and sweeps, and encoding of frames.
#include <cstddef>
#include <optional>
#include <string>

#include "host/apps/serve/messages/shot_message.hpp"
#include "host/apps/serve/session/ego_masks.hpp"
#include "host/device/render/outputs/picture_bytes.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli::serve {

/// Limit of one picture, also of the viewer.
inline constexpr double kMostPixels = 4096.0 * 4096.0;
/// Limit of all pictures of a request.
inline constexpr double kMostPixelsTogether = 4.0 * kMostPixels;

/// Returns the camera of a request with the picture's size: the scene's own if the message equals the
/// description of get_available_cameras or contains a logical_id only. Errors as in camera_of(); throws
/// Refusal{kInvalid} for invalid sizes.
[[nodiscard]] Camera requested_camera(const ServedScene& scene, const proto::RGBRenderRequest& request);

/// Encoding of a picture.
struct PictureCode {
  proto::ImageFormat format = proto::PNG;
  int quality = 95;  // for JPEG
  std::optional<EgoMaskId> ego_mask;
};
/// Throws Refusal{kInvalid}, Refusal{kUnimplemented} for unsupported formats, Refusal{kNotFound} for an unknown
/// mask.
[[nodiscard]] PictureCode picture_code(const proto::RGBRenderRequest& request, const EgoMasks& ego_masks);

/// Returns the order of a picture's bytes on the device; pictures without a mask are converted to bytes there.
[[nodiscard]] PixelOrder order_of(const PictureCode& code);
/// Returns [3][height][width], rounded as in write_image().
[[nodiscard]] std::string planar_bytes(const Image& image);
/// Encodes `bytes` in order_of(code).
[[nodiscard]] std::string encoded(std::string bytes, int width, int height, const PictureCode& code);
[[nodiscard]] std::string encoded(const Image& image, const PictureCode& code);

/// Returns the model of a protocol's LiDAR type, for requests that name none. Throws Refusal{kInvalid}.
[[nodiscard]] std::string lidar_name(const proto::LidarSpec& spec);

/// Selects the returned rays by the request's filter; without a filter as in LidarFrame. Throws
/// Refusal{kInvalid}, and Refusal{kUnimplemented} for filters by distance.
struct ReturnFilter {
  std::optional<double> most_drop;      // largest drop probability
  std::optional<double> least_opacity;  // least 1 - transmittance
};
[[nodiscard]] ReturnFilter return_filter(const proto::LidarRenderRequest& request);

/// Returns a sweep in the LiDAR's axes at the shot's end.
[[nodiscard]] LidarFrame take_sweep(const Frame& frame, const ReturnFilter& filter);
void print_points(const LidarModel& lidar,
                  const LidarFrame& frame,
                  const Shot& shot,
                  proto::LidarRenderReturn& reply);

}  // namespace simuli::serve
