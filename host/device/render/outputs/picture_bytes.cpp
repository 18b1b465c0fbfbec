// Launcher of "kernels/picture_bytes.cl".
#include "host/device/render/outputs/picture_bytes.hpp"

#include <cstdint>
#include <map>

#include "host/core/base/error.hpp"
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

struct PictureBytes::State {
  explicit State(const Device& on) : device(on), bytes(on, "picture bytes") {}

  struct Converter {
    Kernel kernel;
    std::uint32_t lanes;
  };
  Converter& converter(Precision precision) {
    const auto found = converters.find(precision);
    if (found != converters.end()) return found->second;
    const int lanes = lane_shape_of(device, precision).lanes;
    const Program program(device, "kernels/picture_bytes.cl", lane_options(device, precision, lanes));
    return converters
        .emplace(precision, Converter{Kernel(program, "picture_bytes"), static_cast<std::uint32_t>(lanes)})
        .first->second;
  }

  Device device;
  std::map<Precision, Converter> converters;
  Buffer<std::uint8_t> bytes;  // reused: each frame's download is queued before the next frame is written
};

PictureBytes::PictureBytes(const Device& device) : state_(std::make_unique<State>(device)) {}
PictureBytes::PictureBytes(PictureBytes&&) noexcept = default;
PictureBytes& PictureBytes::operator=(PictureBytes&&) noexcept = default;
PictureBytes::~PictureBytes() = default;

ByteDownload PictureBytes::start(const Frame& frame, PixelOrder order) {
  const Camera& camera = frame.sensor().camera();
  const FrameBuffersOfRays of = FrameAccess::buffers(frame);
  const std::array<float, 3>& background = FrameAccess::background(frame);
  const RealBuffer& shown = of.picture != nullptr ? *of.picture : of.outputs;
  const auto width = static_cast<std::uint32_t>(camera.width),
             height = static_cast<std::uint32_t>(camera.height);
  const bool is_planar = order == PixelOrder::kPlanar;
  State& s = *state_;
  s.bytes.reserve(3 * of.rays);
  State::Converter& on = s.converter(shown.precision());
  on.kernel.run_over((width + on.lanes - 1) / on.lanes * height,
                     {{"width", width},
                      {"height", height},
                      {"slots", static_cast<std::uint32_t>(of.slots)},
                      {"slot_of_ray", of.slot_of_ray},
                      {"shown", shown},
                      {"red", static_cast<double>(background[0])},
                      {"green", static_cast<double>(background[1])},
                      {"blue", static_cast<double>(background[2])},
                      {"pixel_step", is_planar ? 1U : 3U},
                      {"channel_step", is_planar ? width * height : 1U},
                      {"bytes", s.bytes}});
  return ByteDownload(s.bytes);
}

}  // namespace simuli
