#include "host/device/render/scene/frame.hpp"

#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "host/device/render/scene/slot_results.hpp"

namespace simuli {

RealBuffer OutputPool::take(const Device& device, const char* name, Precision precision) {
  for (std::size_t i = free_.size(); i-- > 0;) {
    if (free_[i].precision() != precision || free_[i].name() != name) continue;
    RealBuffer found = std::move(free_[i]);
    free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(i));
    return found;
  }
  return {device, name, precision};
}

void OutputPool::give_back(RealBuffer buffer) {
  if (buffer.capacity() == 0) return;
  if (free_.size() == kMost) free_.erase(free_.begin());
  free_.push_back(std::move(buffer));
}

Frame::State::State(const Device& device,
                    Precision precision,
                    Sensor of,
                    Shot at,
                    FrameRequest as,
                    SensorRays on,
                    std::shared_ptr<OutputPool> from)
    : sensor(std::move(of)),
      shot(std::move(at)),
      request(std::move(as)),
      rays(std::move(on)),
      pool(std::move(from)),
      outputs(pool->take(device, "ray outputs", precision)),
      picture(pool->take(device, "graded picture", precision)) {}

// In the in-order queue, work on the buffers precedes the work of the next frame.
Frame::State::~State() {
  pool->give_back(std::move(outputs));
  pool->give_back(std::move(picture));
}

/// The last rendering of a frame.
const Frame::State& Frame::last_of(const State& state) {
  return state.of_actors ? *state.of_actors->state_ : state;
}

const Sensor& Frame::sensor() const { return state_->sensor; }
const Shot& Frame::shot() const { return state_->shot; }
bool Frame::is_ready() const { return last_of(*state_).done->is_done(); }
void Frame::wait() const { last_of(*state_).done->wait(); }

void Frame::fetch() const {
  State& s = *state_;
  if (s.of_actors) s.of_actors->fetch();
  if (s.results || s.outputs_coming) return;
  s.outputs_coming.emplace(s.outputs);
  if (s.graded) s.picture_coming.emplace(s.picture);
}

const RayResults& Frame::results() const {
  State& s = *state_;
  if (s.results) return *s.results;
  fetch();
  wait();  // may be interrupted; a download can be taken only once
  const std::vector<float> outputs = s.outputs_coming->take();
  const std::vector<float> picture = s.graded ? s.picture_coming->take() : std::vector<float>{};
  s.results = results_of(s.rays.grid(), outputs, picture, s.background, s.has_median);
  s.outputs_coming.reset();
  s.picture_coming.reset();
  return *s.results;
}

Image Frame::image() const {
  const Camera& camera = sensor().camera();
  return picture_of(results(), camera);
}

LidarFrame Frame::lidar() const {
  const LidarModel& model = sensor().lidar();
  return lidar_frame(model, sensor().rays(), results());
}

std::vector<Eigen::Vector3d> Frame::points(PointFrame in) const {
  return points_of(sensor().lidar(), lidar(), shot(), in);
}

std::vector<std::uint32_t> Frame::owners() const {
  const State& s = *state_;
  if (!s.request.actors) {
    throw Error(ErrorKind::kUsage,
                "actors: found a frame without them, allowed one that was requested with them: C++ "
                "FrameRequest::actors, C with_actors, Python actors=True");
  }
  if (!s.of_actors) return std::vector<std::uint32_t>(s.rays.grid().rays, 0);
  const std::vector<float>& ids = s.of_actors->results().median;
  std::vector<std::uint32_t> actors(ids.begin(), ids.end());
  // Visibility sets, disoccluded and inpainted sets count as background.
  for (std::uint32_t& id : actors) id = s.owner_numbers.is_actor(id) ? id : 0;
  return actors;
}

std::vector<std::uint32_t> Frame::actors() const {
  std::vector<std::uint32_t> actors = owners();
  const State& s = *state_;
  if (!s.of_actors) return actors;
  const std::vector<float>& distances = s.of_actors->results().feature[0];
  const RayGrid& grid = s.rays.grid();
  const std::size_t slots = grid.frame.slots;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    if (grid.ray_of_slot[slot] < 0) continue;
    const auto ray = static_cast<std::size_t>(grid.ray_of_slot[slot]);
    if (actors[ray] == 0) continue;
    const auto at = [&](std::size_t row) { return static_cast<double>(grid.sensor_ray[row * slots + slot]); };
    const Eigen::Vector3d direction(at(0), at(1), at(2)), origin(at(3), at(4), at(5));
    const Eigen::Vector3d p_sensor = origin + static_cast<double>(distances[ray]) * direction;
    if (!s.boxes->is_of_body(actors[ray] - 1, p_sensor, at(6))) actors[ray] = 0;
  }
  return actors;
}

void FrameAccess::need_of(const Frame& frame, const Scene& scene, std::string_view call) {
  if (is_of(frame, scene)) return;
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: found a frame of another scene, allowed one of the scene as it is", call));
}

FrameBuffersOfRays FrameAccess::buffers(const Frame& frame) {
  const Frame::State& s = *frame.state_;
  const RayMap& map = s.rays.map();
  return {s.outputs,
          s.graded ? &s.picture : nullptr,
          map.ray_of_slot,
          map.slot_of_ray,
          s.rays.grid().frame.slots,
          s.rays.grid().rays};
}

}  // namespace simuli
