#include "host/device/render/frame/room.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/device/render/frame/frame_buffers.hpp"
#include "host/device/render/rays/ray_buffers.hpp"

namespace simuli {

const Camera& with_room_on(const Device& device, const Camera& camera, Precision precision) {
  constexpr std::uint64_t kHost = 36;  // host bytes per ray
  const DeviceInfo& info = device.info();
  const std::uint64_t rays =
      static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
  std::uint64_t buffer = 0;
  std::uint64_t all = info.is_cpu ? rays * kHost : 0;
  const auto add = [&](const std::vector<BufferBytes>& buffers) {
    for (const BufferBytes& one : buffers) {
      buffer = std::max(buffer, one.bytes);
      all += one.bytes;
    }
  };
  add(RayLayout(device, precision).bytes({.slots = rays}));
  add(RequestedRays(device, precision).bytes({.slots = rays}));
  // With a moving camera and moving actors a ray has seven reals.
  const FrameSizes sizes{.slots = rays, .ray_rows = 7};
  add(WorldRays(device, precision).bytes(sizes));
  add(Blended(device, precision).bytes(sizes));
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
