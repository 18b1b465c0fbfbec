#include "host/render/options/validate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>

#include "host/base/error.hpp"

namespace simuli {

void validate(const RenderOptions& options) {
  const auto need = [](bool holds, const char* field, double found, const char* allowed) {
    if (holds) return;
    throw Error(ErrorKind::kUsage, fmt::format("render.{}: found {}, allowed {}", field, found, allowed));
  };
  const RenderOptions& o = options;
  need(o.shutter_iterations >= 0 && o.shutter_iterations <= 64,
       "shutter_iterations",
       o.shutter_iterations,
       "0 to 64");
  need(o.alpha_cut >= 1e-30 && o.alpha_cut <= 0.5, "alpha_cut", o.alpha_cut, "1e-30 to 0.5");
  need(o.transmittance_cut >= 0.0 && o.transmittance_cut <= 0.5,
       "transmittance_cut",
       o.transmittance_cut,
       "0 to 0.5");
  need(o.camera_filter_px2 >= 0.0 && o.camera_filter_px2 <= 100.0,
       "camera_filter_px2",
       o.camera_filter_px2,
       "0 to 100");
  if (o.projection != Projection::kUnscented && o.extent == Extent::kExact) {
    throw Error(
        ErrorKind::kUsage,
        "render.projection: found another than unscented beside extent=exact, which has no use for it; "
        "allowed with extent=unscented");
  }
  need(o.sh_error > 0.0 && o.sh_error <= 10.0, "sh_error", o.sh_error, "more than 0, to 10");
  need(o.max_instances >= 1, "max_instances", static_cast<double>(o.max_instances), "1 or more");
}

void need_numbers(std::span<const float> values, float largest, const char* what) {
  const auto bad =
      std::find_if(values.begin(), values.end(), [&](float v) { return !(std::abs(v) <= largest); });
  if (bad == values.end()) return;
  throw Error(
      ErrorKind::kNumeric,
      fmt::format(
          "{}: found {} as value {}, allowed numbers up to {:g}", what, *bad, bad - values.begin(), largest));
}

const Camera& with_room_on(const Device& device, const Camera& camera, const RenderOptions& options) {
  constexpr std::uint64_t kLargest = 7, kAll = 21;  // reals of a ray: of its own, and with outputs
  constexpr std::uint64_t kHost = 36;               // bytes of a ray that the host keeps
  const DeviceInfo& info = device.info();
  const std::uint64_t real_bytes = options.precision == Precision::kDouble ? 8 : 4;
  const std::uint64_t rays =
      static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
  const std::uint64_t buffer = rays * kLargest * real_bytes;
  const std::uint64_t all = rays * (kAll * real_bytes + (info.is_cpu ? kHost : 0));
  if (buffer <= info.max_alloc_bytes && all <= info.global_bytes) return camera;
  throw Error(
      ErrorKind::kDevice,
      fmt::format("camera {}: found {} x {} pixels, which take {:.1f} GB, {:.1f} of them in one buffer, "
                  "allowed {:.1f} and {:.1f} GB on {}; a smaller scale takes less",
                  camera.name,
                  camera.width,
                  camera.height,
                  static_cast<double>(all) / 1e9,
                  static_cast<double>(buffer) / 1e9,
                  static_cast<double>(info.global_bytes) / 1e9,
                  static_cast<double>(info.max_alloc_bytes) / 1e9,
                  info.label()));
}

}  // namespace simuli
