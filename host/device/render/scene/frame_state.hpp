#pragma once
// Device state of a Frame, for this module and for callers that expose device memory.
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "host/core/scene/occluders.hpp"
#include "host/device/render/scene/actor_boxes.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/runtime/pending.hpp"

namespace simuli {

/// Output buffers of released frames, for reuse.
class OutputPool {
 public:
  [[nodiscard]] RealBuffer take(const Device& device, const char* name, Precision precision);
  void give_back(RealBuffer buffer);

 private:
  static constexpr std::size_t kMost = 8;  // free buffers; further ones are released
  std::vector<RealBuffer> free_;
};

struct Frame::State {
  State(const Device& device,
        Precision precision,
        Sensor of,
        Shot at,
        FrameRequest as,
        SensorRays on,
        std::shared_ptr<OutputPool> from);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  Sensor sensor;
  Shot shot;
  FrameRequest request;
  std::weak_ptr<const Scene> scene;
  OwnerNumbers owner_numbers;  // of the scene
  SensorRays rays;
  std::shared_ptr<OutputPool> pool;
  RealBuffer outputs;  // [SIM_OUTPUTS][slots], cameras without the last row
  RealBuffer picture;  // [3][slots], with colour grid
  bool graded = false;
  bool has_median = false;
  std::array<float, 3> background{};
  std::optional<Event> done;
  std::optional<Download> outputs_coming, picture_coming;
  std::optional<RayResults> results;
  std::optional<Frame> of_actors;  // rendering with View::actor_ids; only for scenes with actors, on request
  std::optional<ActorBoxes> boxes;  // with of_actors
};

/// Device buffers of a frame's results in slot order, with the maps between rays and slots. They live as long
/// as the frame, and are valid when the frame is_ready().
struct FrameBuffersOfRays {
  const RealBuffer&
      outputs;  // [6][slots]: features, transmittance, distance, median; LiDARs: [7], drop logit
  const RealBuffer* picture;  // [3][slots] after the colour grid, in place of the features; null without
  const Buffer<std::int32_t>& ray_of_slot;  // [slots], -1: none
  const Buffer<std::int32_t>& slot_of_ray;  // [rays], -1: none
  std::size_t slots = 0;
  std::size_t rays = 0;
};

struct FrameAccess {
  /// Whether the frame was rendered of this scene in its current state.
  [[nodiscard]] static bool is_of(const Frame& frame, const Scene& scene) {
    return frame.state_->scene.lock().get() == &scene;
  }
  /// Throws Error{kUsage} when it was not; `call` names the call.
  static void need_of(const Frame& frame, const Scene& scene, std::string_view call);
  [[nodiscard]] static FrameBuffersOfRays buffers(const Frame& frame);
  [[nodiscard]] static _cl_event* ready(const Frame& frame) { return frame.state_->done->handle(); }
  [[nodiscard]] static const std::array<float, 3>& background(const Frame& frame) {
    return frame.state_->background;
  }
  [[nodiscard]] static const RayGrid& grid(const Frame& frame) { return frame.state_->rays.grid(); }
  [[nodiscard]] static const SensorRays& rays(const Frame& frame) { return frame.state_->rays; }
};

}  // namespace simuli
