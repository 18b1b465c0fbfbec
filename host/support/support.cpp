// Launcher of "kernels/support/support.cl".
#include "host/support/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/render/device/buffer_table.hpp"
#include "host/render/options/lane_shape.hpp"
#include "host/render/scene/frame_state.hpp"
#include "host/runtime/kernel.hpp"

namespace simuli {
namespace {

constexpr std::size_t kPlace = 16, kGrid = 8;  // reals, as in the kernel
constexpr std::size_t kRun = 4;                // slots told alike
constexpr double kBoxMargin_m = 0.1;

struct SupportSizes {
  std::uint64_t slots = 0;
};
struct SupportBuffers : BufferTable<SupportSizes> {
  using BufferTable::BufferTable;
  Reals sensor{*this, "support_sensor", [](const SupportSizes&) { return 2 * std::uint64_t{kPlace}; }};
  Reals boxes{*this, "support_boxes", [](const SupportSizes&) { return std::uint64_t{kPlace}; }};
  Reals views{*this, "support_places", [](const SupportSizes&) { return std::uint64_t{kPlace}; }};
  Reals grids{*this, "support_grids", [](const SupportSizes&) { return std::uint64_t{kGrid}; }};
  Reals cells{*this, "support_cells", [](const SupportSizes&) { return std::uint64_t{4}; }};
  Reals trust{*this, "support_trust", [](const SupportSizes&) { return std::uint64_t{10}; }};
  Reals support{*this, "support", [](const SupportSizes& s) { return s.slots; }};
};

void append_place(std::vector<double>& to,
                  const Pose& pose,
                  double factor,
                  const std::array<double, 4>& behind) {
  const Eigen::Matrix3d rotation = factor * pose.rotation.toRotationMatrix();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) to.push_back(rotation(row, column));
  }
  to.insert(to.end(), pose.translation.begin(), pose.translation.end());
  to.insert(to.end(), behind.begin(), behind.end());
}

Pose moved(Pose pose, const Eigen::Vector3d& by_m) {
  pose.translation += by_m;
  return pose;
}

/// What one frame is compared with.
struct Comparison {
  std::uint32_t actors = 0;
  std::vector<double> boxes, places, grids;
};

const Actor* recorded_actor(const SupportRecord& record, const std::string& name, const ActorCopies& copies) {
  const auto copy = copies.find(name);
  const std::string& original = copy == copies.end() ? name : copy->second;
  const auto found = std::find_if(
      record.actors.begin(), record.actors.end(), [&](const Actor& actor) { return actor.name == original; });
  return found == record.actors.end() ? nullptr : &*found;
}

Comparison comparison(const SupportRecord& record,
                      const std::vector<std::size_t>& views,
                      const std::vector<std::size_t>& first_cells,
                      double rays_now,
                      const Shot& shot,
                      const Eigen::Vector3d& centre,
                      const Scene& scene,
                      const ActorCopies& copies) {
  Comparison out;
  for (const std::size_t v : views) {
    const SupportGrid& grid = record.sensors[record.views[v].sensor].grid;
    for (const double value : {grid.first_column,
                               grid.columns_per_unit,
                               grid.first_row,
                               grid.rows_per_unit,
                               static_cast<double>(grid.columns),
                               static_cast<double>(grid.rows),
                               static_cast<double>(first_cells[v]),
                               grid.rays_per_rad / rays_now})
      out.grids.push_back(value);
    append_place(out.places, moved(record.views[v].world_from_view, -centre).inverse(), 1.0, {1.0, 1.0});
  }
  const std::vector<ActorView> now = actors_during(scene.actors, shot, centre);
  for (std::size_t a = 0; a < now.size(); ++a) {
    if (!now[a].is_there) continue;
    const Actor& actor = scene.actors[a];
    const Pose pose = interpolate(now[a].scene_from_actor_start, now[a].scene_from_actor_end, 0.5);
    const Eigen::Vector3d half = 0.5 * actor.size_m + Eigen::Vector3d::Constant(kBoxMargin_m);
    append_place(out.boxes, pose.inverse(), 1.0, {half.x(), half.y(), half.z()});
    ++out.actors;
    const Actor* const recorded = recorded_actor(record, actor.name, copies);
    for (const std::size_t v : views) {
      const SupportView& view = record.views[v];
      if (recorded == nullptr || !recorded->is_there(view.time_s)) {
        append_place(out.places, {}, 1.0, {0.0, 1.0});
        continue;
      }
      const double factor = recorded->size_m.x() / actor.size_m.x();
      append_place(
          out.places, view.world_from_view.inverse() * recorded->at(view.time_s), factor, {1.0, factor});
    }
  }
  return out;
}

double rays_per_rad_of(const Sensor& sensor) {
  return sensor.is_camera() ? rays_per_rad(sensor.camera()) : rays_per_rad(sensor.lidar());
}

}  // namespace

const SupportTrust& support_trust(SetKind kind) {
  // Fitted to the street (400 iterations) on its path and 1.5 m to either side of it: bench/RESULTS.md.
  static const SupportTrust camera{-7.93, 2.29, -0.71, 0.51, -1.33, -1.05, -0.84, 0.0, 0.0, 0.0};
  static const SupportTrust lidar{-2.52, 0.0, 0.0, 0.0, -1.00, 0.0, -0.95, -3.10, 4.50, -1.67};
  return kind == SetKind::kCamera ? camera : lidar;
}

std::vector<std::size_t> support_views_around(const SupportRecord& record,
                                              SetKind kind,
                                              const Eigen::Vector3d& p_world) {
  std::vector<std::size_t> views;
  for (std::size_t i = 0; i < record.views.size(); ++i) {
    if (record.sensors[record.views[i].sensor].kind == kind) views.push_back(i);
  }
  if (views.size() <= kMostSupportViews) return views;
  std::stable_sort(views.begin(), views.end(), [&](std::size_t a, std::size_t b) {
    const auto distance2 = [&](std::size_t v) {
      return (record.views[v].world_from_view.translation - p_world).squaredNorm();
    };
    return distance2(a) < distance2(b);
  });
  constexpr std::size_t kNearest = kMostSupportViews / 2, kOthers = kMostSupportViews - kNearest;
  std::vector<std::size_t> some(views.begin(), views.begin() + kNearest);
  const std::size_t rest = views.size() - kNearest;
  for (std::size_t k = 0; k < kOthers; ++k)
    some.push_back(views[kNearest + (2 * k + 1) * rest / (2 * kOthers)]);
  return some;
}

struct SupportOnDevice::State {
  /// Of one precision.
  struct Stage {
    Stage(const Device& device, Precision precision)
        : lanes(lane_shape_of(device, precision).lanes),
          buffers(device, precision),
          kernel(Program(device, "kernels/support/support.cl", lane_options(device, precision)), "support") {}
    int lanes;
    SupportBuffers buffers;
    Kernel kernel;
  };

  State(const Device& on, std::shared_ptr<const SupportRecord> of) : device(on), record(std::move(of)) {
    if (record == nullptr) {
      throw Error(
          ErrorKind::kUsage,
          "support: found a scene without a record of the frames it was made of, allowed one trained since "
          "there is support: train it anew");
    }
    std::size_t cells = 0;
    for (const SupportView& view : record->views) {
      first_cells.push_back(cells);
      cells += record->sensors[view.sensor].grid.cells();
    }
  }

  Stage& stage(Precision precision) {
    std::optional<Stage>& stage = precision == Precision::kFloat ? single : twice;
    if (stage) return *stage;
    stage.emplace(device, precision);
    std::vector<float> cells;
    cells.reserve(4 * record->cells.size() + 4);
    for (const SupportCell& c : record->cells) {
      for (const float value : {c.nearest_m, c.farthest_m, c.log_error, c.log_contrast})
        cells.push_back(value);
    }
    if (cells.empty()) cells.resize(4, 0.0F);
    stage->buffers.cells.assign(cells);
    return *stage;
  }

  Device device;
  std::shared_ptr<const SupportRecord> record;
  std::vector<std::size_t> first_cells;  // of the views
  std::optional<Stage> single, twice;
};

SupportOnDevice::SupportOnDevice(const Device& device, std::shared_ptr<const SupportRecord> record)
    : state_(std::make_unique<State>(device, std::move(record))) {}
SupportOnDevice::~SupportOnDevice() = default;
SupportOnDevice::SupportOnDevice(SupportOnDevice&&) noexcept = default;
SupportOnDevice& SupportOnDevice::operator=(SupportOnDevice&&) noexcept = default;

std::vector<float> SupportOnDevice::of(const Frame& frame, const Scene& scene, const ActorCopies& copies) {
  State& s = *state_;
  const Sensor& sensor = frame.sensor();
  const Shot& shot = frame.shot();
  const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
  const Eigen::Vector3d centre = shot.pose_at(0.5).translation;
  const std::vector<std::size_t> views = support_views_around(*s.record, kind, centre);
  const SensorRays& rays = FrameAccess::rays(frame);
  std::vector<float> out(rays.grid().rays, 0.0F);
  if (views.empty()) return out;

  const RealBuffer& outputs = FrameAccess::buffers(frame).outputs;
  State::Stage& stage = s.stage(outputs.precision());
  SupportBuffers& b = stage.buffers;
  const Comparison with =
      comparison(*s.record, views, s.first_cells, rays_per_rad_of(sensor), shot, centre, scene, copies);
  std::vector<double> places;
  append_place(places, moved(shot.world_from_sensor_start, -centre), 1.0, {});
  append_place(places, moved(shot.world_from_sensor_end, -centre), 1.0, {});
  b.sensor.assign(places);
  b.boxes.assign(with.boxes.empty() ? std::vector<double>(kPlace, 0.0) : with.boxes);
  b.views.assign(with.places);
  b.grids.assign(with.grids);
  const SupportTrust& t = support_trust(kind);
  b.trust.assign(std::vector<double>{
      t.constant, t.looks, t.angle, t.scale, t.error, t.contrast, t.edge, t.doubt, t.drop, t.apart});
  const shared::FrameParams& frame_params = rays.grid().frame;
  b.support.reserve(frame_params.slots);
  const std::size_t slots_of_item = kRun * static_cast<std::size_t>(stage.lanes);
  stage.kernel.run_over((frame_params.slots + slots_of_item - 1) / slots_of_item,
                        {{"frame", frame_params},
                         {"actors", with.actors},
                         {"count", static_cast<std::uint32_t>(views.size())},
                         {"drops", std::uint32_t{sensor.is_camera() ? 0U : 1U}},
                         {"sensor_ray", rays.buffers().sensor_ray},
                         {"out", outputs},
                         {"sensor", b.sensor},
                         {"boxes", b.boxes},
                         {"views", b.views},
                         {"grids", b.grids},
                         {"cells", b.cells},
                         {"trust", b.trust},
                         {"support", b.support}});
  const std::vector<float> by_slot = b.support.download_float();
  for (std::size_t slot = 0; slot < frame_params.slots; ++slot) {
    const std::int32_t ray = rays.grid().ray_of_slot[slot];
    if (ray >= 0) out[static_cast<std::size_t>(ray)] = by_slot[slot];
  }
  return out;
}

Image SupportOnDevice::image_of(const Frame& frame, const Scene& scene, const ActorCopies& copies) {
  const Camera& camera = frame.sensor().camera();
  Image image(camera.width, camera.height, 1);
  image.data = of(frame, scene, copies);
  return image;
}

}  // namespace simuli
