// Launcher of "kernels/support.cl".
#include "host/device/support/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "cl/shared/support.h"
#include "host/core/base/error.hpp"
#include "host/device/render/device/buffer_table.hpp"
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

template <>
struct ClTypeName<shared::SupportFrame<double>> {
  static constexpr std::string_view value = "SupportFrame";
};
template <>
struct ClTypeName<shared::SupportGrid<double>> {
  static constexpr std::string_view value = "SupportGrid";
};
template <>
struct ClTypeName<shared::SupportBox<double>> {
  static constexpr std::string_view value = "SupportBox";
};
template <>
struct ClTypeName<shared::SupportView<double>> {
  static constexpr std::string_view value = "SupportView";
};

namespace {

constexpr double kBoxMargin_m = 0.1;

struct SupportSizes {
  std::uint64_t rays = 0;
};
struct SupportBuffers : BufferTable<SupportSizes> {
  using BufferTable::BufferTable;
  // Assigned for each frame.
  Structs<shared::SupportFrame> requested{
      *this, "requested", [](const SupportSizes&) { return std::uint64_t{1}; }};
  Structs<shared::SupportGrid> grids{*this, "grids", [](const SupportSizes&) { return std::uint64_t{1}; }};
  Structs<shared::SupportBox> boxes{*this, "boxes", [](const SupportSizes&) { return std::uint64_t{1}; }};
  Structs<shared::SupportView> views{*this, "views", [](const SupportSizes&) { return std::uint64_t{1}; }};
  Reals cells{*this, "cells", [](const SupportSizes&) { return std::uint64_t{4}; }};
  Reals support{*this, "support", [](const SupportSizes& s) { return s.rays; }};
};

template <template <class> class Struct>
void append(std::vector<double>& to, const Struct<double>& one) {
  const auto reals = shared::reals_of(one);
  to.insert(to.end(), reals.begin(), reals.end());
}
void set_rotation(double (&to)[9], const Eigen::Matrix3d& rotation) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{to} = rotation;
}
shared::SupportPose<double> support_pose(const Pose& pose) {
  shared::SupportPose<double> out{};
  set_rotation(out.rotation, pose.rotation.toRotationMatrix());
  Eigen::Map<Eigen::Vector3d>{out.translation} = pose.translation;
  return out;
}
/// Returns a recorded view relative to axes in which lengths are `factor` times the recorded ones.
shared::SupportView<double> support_view(const Pose& view_from_axes, double factor) {
  shared::SupportView<double> out{};
  out.there = 1.0;
  out.enlargement = factor;
  set_rotation(out.rotation, factor * view_from_axes.rotation.toRotationMatrix());
  Eigen::Map<Eigen::Vector3d>{out.position} = view_from_axes.inverse().translation / factor;
  return out;
}

Pose moved(Pose pose, const Eigen::Vector3d& by_m) {
  pose.translation += by_m;
  return pose;
}

/// Inputs of the comparison of one frame with recorded views.
struct Comparison {
  std::uint32_t actors = 0;
  std::vector<double> boxes, views, grids;  // reals of the kernel's structs
};

const Actor* recorded_actor(const SupportRecord& record, const std::string& name, const ActorCopies& copies) {
  const std::string& original = original_of(copies, name);
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
    append(out.grids,
           shared::SupportGrid<double>{grid.first_column,
                                       grid.columns_per_unit,
                                       grid.first_row,
                                       grid.rows_per_unit,
                                       static_cast<double>(grid.columns),
                                       static_cast<double>(grid.rows),
                                       static_cast<double>(first_cells[v]),
                                       grid.rays_per_rad / rays_now});
    append(out.views, support_view(moved(record.views[v].world_from_view, -centre).inverse(), 1.0));
  }
  const std::vector<ActorView> now = actors_during(scene.actors, shot, centre);
  for (std::size_t a = 0; a < now.size(); ++a) {
    if (!now[a].is_there) continue;
    const Actor& actor = scene.actors[a];
    const Pose pose = interpolate(now[a].scene_from_actor_start, now[a].scene_from_actor_end, 0.5);
    const Eigen::Vector3d half = 0.5 * actor.size_m + Eigen::Vector3d::Constant(kBoxMargin_m);
    append(out.boxes,
           shared::SupportBox<double>{support_pose(pose.inverse()), {half.x(), half.y(), half.z()}});
    ++out.actors;
    const Actor* const recorded = recorded_actor(record, actor.name, copies);
    for (const std::size_t v : views) {
      const SupportView& view = record.views[v];
      if (recorded == nullptr || !recorded->is_there(view.time_s)) {
        append(out.views, shared::SupportView<double>{});
        continue;
      }
      const double factor = recorded->size_m.x() / actor.size_m.x();
      append(out.views, support_view(view.world_from_view.inverse() * recorded->at(view.time_s), factor));
    }
  }
  return out;
}

double rays_per_rad_of(const Sensor& sensor) {
  return sensor.is_camera() ? rays_per_rad(sensor.camera()) : rays_per_rad(sensor.lidar());
}

/// Number of rows of a pixel block that share one lookup, so that they span at most a quarter of a recorded
/// cell.
std::uint32_t rows_alike(const SupportRecord& record,
                         const std::vector<std::size_t>& views,
                         const Sensor& sensor) {
  if (!sensor.is_camera()) return 1;
  double cell_px = std::numeric_limits<double>::infinity();
  for (const std::size_t v : views) {
    const SupportGrid& grid = record.sensors[record.views[v].sensor].grid;
    cell_px = std::min(cell_px, rays_per_rad_of(sensor) / grid.rows_per_unit);
  }
  constexpr double kNearly = 0.9;
  std::uint32_t rows = 1;
  while (rows < SIM_BLOCK_SIDE && cell_px * cell_px > kNearly * 4.0 * 2.0 * rows * SIM_SUPPORT_RUN) rows *= 2;
  return rows;
}

}  // namespace

const SupportTrust& support_trust(SetKind kind) {
  // Cameras: fitted to the street on and off its path, to held-out pictures of drives, and to held-out cameras
  // of PandaSet; LiDARs: to the street on its path and 1.5 m to either side (bench/RESULTS.md).
  static const SupportTrust camera{-6.28, -0.98, 1.64, -1.44, -0.25, -0.79, 0.0, 0.0, 0.0};
  static const SupportTrust lidar{-2.52, 0.0, 0.0, -1.00, 0.0, -0.95, -3.10, 4.50, -1.67};
  return kind == SetKind::kCamera ? camera : lidar;
}

std::vector<std::size_t> support_views_around(const SupportRecord& record,
                                              SetKind kind,
                                              const Pose& world_from_view) {
  constexpr double kAside_m = 10.0;
  const bool is_camera = kind == SetKind::kCamera;
  const auto forward = [](const Pose& pose) { return pose.rotation * Eigen::Vector3d::UnitX(); };
  std::vector<std::pair<double, std::size_t>> views;
  for (std::size_t i = 0; i < record.views.size(); ++i) {
    if (record.sensors[record.views[i].sensor].kind != kind) continue;
    const Pose& view = record.views[i].world_from_view;
    double away_m = (view.translation - world_from_view.translation).norm();
    if (is_camera) away_m += kAside_m * (1.0 - forward(view).dot(forward(world_from_view)));
    views.emplace_back(away_m, i);
  }
  std::sort(views.begin(), views.end());
  const std::size_t count = std::min(views.size(), kMostSupportViews);
  const std::size_t nearest = is_camera ? count : std::min(count, kMostSupportViews / 2);
  const std::size_t others = count - nearest;
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < nearest; ++k) some.push_back(views[k].second);
  for (std::size_t k = 0; k < others; ++k)
    some.push_back(views[nearest + (2 * k + 1) * (views.size() - nearest) / (2 * others)].second);
  return some;
}

struct SupportOnDevice::State {
  /// Buffers and kernels of one precision.
  struct Stage {
    Stage(const Device& device, Precision precision)
        : lanes(lane_shape_of(device, precision).lanes),
          buffers(device, precision),
          kernel(Program(device, "kernels/support.cl", lane_options(device, precision)), "support") {}
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
    std::vector<double> cells;
    cells.reserve(4 * record->cells.size() + 4);
    for (std::size_t v = 0; v < record->views.size(); ++v) {
      const SupportSensor& sensor = record->sensors[record->views[v].sensor];
      const SupportTrust& trust = support_trust(sensor.kind);
      for (std::size_t i = first_cells[v]; i < first_cells[v] + sensor.grid.cells(); ++i) {
        const SupportCell& c = record->cells[i];
        const double nearest = c.nearest_m, farthest = c.farthest_m;
        const double depth = (farthest - nearest) / std::max(farthest, 1e-6);
        cells.insert(cells.end(),
                     {nearest,
                      farthest,
                      trust.error * c.log_error + trust.contrast * c.log_contrast + trust.edge * depth,
                      0.0});
      }
    }
    if (cells.empty()) cells.resize(4, 0.0);
    stage->buffers.cells.assign(cells);
    return *stage;
  }

  Device device;
  std::shared_ptr<const SupportRecord> record;
  std::vector<std::size_t> first_cells;  // first cell of each view
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
  const Pose world_from_sensor = shot.pose_at(0.5);
  const Eigen::Vector3d& centre = world_from_sensor.translation;
  const std::vector<std::size_t> views = support_views_around(
      *s.record,
      kind,
      sensor.is_camera() ? world_from_sensor * grid_from_camera().inverse() : world_from_sensor);
  const SensorRays& rays = FrameAccess::rays(frame);
  const RayGrid& grid = rays.grid();
  if (views.empty()) return std::vector<float>(grid.rays, 0.0F);

  const RealBuffer& outputs = FrameAccess::buffers(frame).outputs;
  State::Stage& stage = s.stage(outputs.precision());
  SupportBuffers& b = stage.buffers;
  const Comparison with =
      comparison(*s.record, views, s.first_cells, rays_per_rad_of(sensor), shot, centre, scene, copies);
  const SupportTrust& t = support_trust(kind);
  b.requested.assign(shared::reals_of(
      shared::SupportFrame<double>{support_pose(moved(shot.world_from_sensor_start, -centre)),
                                   support_pose(moved(shot.world_from_sensor_end, -centre)),
                                   t.constant,
                                   t.angle,
                                   t.scale,
                                   t.doubt,
                                   t.drop,
                                   t.apart}));
  b.grids.assign(with.grids);
  b.boxes.assign(with.boxes);
  b.views.assign(with.views);
  b.support.reserve(grid.rays);
  if (grid.without_ray > 0) b.support.fill(0.0);
  const std::uint32_t rows = rows_alike(*s.record, views, sensor);
  const std::size_t slots_of_item =
      std::size_t{SIM_SUPPORT_RUN} * rows * static_cast<std::size_t>(stage.lanes);
  stage.kernel.run_over((grid.frame.slots + slots_of_item - 1) / slots_of_item,
                        {{"frame", grid.frame},
                         {"actors", with.actors},
                         {"count", static_cast<std::uint32_t>(views.size())},
                         {"drops", std::uint32_t{sensor.is_camera() ? 0U : 1U}},
                         {"rows", rows},
                         {"in_blocks", std::uint32_t{sensor.is_camera() && grid.without_ray == 0 ? 1U : 0U}},
                         {"sensor_ray", rays.buffers().requested.sensor_ray},
                         {"ray_of_slot", rays.map().ray_of_slot},
                         {"out", outputs},
                         b});
  return b.support.download_float();
}

Image SupportOnDevice::image_of(const Frame& frame, const Scene& scene, const ActorCopies& copies) {
  const Camera& camera = frame.sensor().camera();
  Image image(camera.width, camera.height, 1);
  image.data = of(frame, scene, copies);
  return image;
}

}  // namespace simuli
