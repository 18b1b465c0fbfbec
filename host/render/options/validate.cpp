#include "host/render/options/validate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/fields.hpp"

namespace simuli {

void validate(const RenderOptions& options) {
  check_fields(options);
  if (options.projection != Projection::kUnscented && options.extent == Extent::kExact) {
    throw Error(
        ErrorKind::kUsage,
        "render.projection: found another than unscented beside render.extent=exact, which has no use for "
        "it, allowed with render.extent=unscented");
  }
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
