// Tests support: the kernel against a sequential loop in double, and its meaning.
#include "host/device/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <numeric>
#include <string>

#include "host/core/base/error.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/outputs/cloud.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "tests/render/scene/wall_and_actor.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::at_origin;
using test::still_camera;
using test::still_lidar;
using test::wall_and_actor;

Pose forward_view(const Sensor& sensor, const Pose& world_from_sensor) {
  return sensor.is_camera() ? world_from_sensor * grid_from_camera().inverse() : world_from_sensor;
}

SupportGrid grid_of(const Sensor& sensor) {
  return sensor.is_camera() ? support_grid(sensor.camera()) : support_grid(sensor.lidar());
}

/// Adds a view that shows the frame's content with `error`.
void add_view(SupportRecord& record, const Frame& frame, const Pose& world_from_sensor, double error) {
  const Sensor& sensor = frame.sensor();
  const SupportGrid grid = grid_of(sensor);
  const SetKind kind = sensor.is_camera() ? SetKind::kCamera : SetKind::kLidar;
  if (record.sensors.empty()) record.sensors.push_back({sensor.name(), kind, grid});
  record.views.push_back({0, frame.shot().middle_s(), forward_view(sensor, world_from_sensor)});
  std::vector<SupportCell> cells(grid.cells());
  const RayResults& rays = frame.results();
  for (std::size_t i = 0; i < rays.rays; ++i) {
    Eigen::Vector3d d;
    if (sensor.is_camera()) {
      const int width = sensor.camera().width;
      const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
      d = grid_from_camera().rotation * sensor.camera().unproject({x + 0.5, y + 0.5}).normalized();
    } else {
      d = Lidar::direction(static_cast<double>(sensor.rays().azimuth[i]),
                           static_cast<double>(sensor.rays().elevation[i]));
    }
    const std::size_t cell = grid.cell_of(d);
    if (cell >= cells.size()) continue;
    const bool is_met = rays.transmittance[i] < 0.5F;
    const float r = is_met ? rays.expected_distance(i) : static_cast<float>(kSupportFar_m);
    SupportCell& c = cells[cell];
    c.nearest_m = c.farthest_m == 0.0F ? r : std::min(c.nearest_m, r);
    c.farthest_m = std::max(c.farthest_m, r);
    c.log_error = static_cast<float>(std::log(error));
    c.log_contrast = static_cast<float>(std::log(0.05));
  }
  record.cells.insert(record.cells.end(), cells.begin(), cells.end());
}

/// Result of the kernel for one ray: contributions of views at its end, and its own.
struct Expected {
  double odds = 0.0, own_odds = 0.0, at_all = 0.0;
  /// Returns the support of a ray whose end is looked up at `told`.
  [[nodiscard]] double support(const Expected& reported) const {
    return reported.at_all / (1.0 + std::exp(-reported.odds - own_odds));
  }
};
std::vector<Expected> expected(const SupportRecord& record, const Frame& frame, const Scene& scene) {
  const Sensor& sensor = frame.sensor();
  const bool is_camera = sensor.is_camera();
  const RayResults& rays = frame.results();
  const Pose world_from_sensor = frame.shot().pose_at(0.5);
  const auto views = support_views_around(
      record, is_camera ? SetKind::kCamera : SetKind::kLidar, forward_view(sensor, world_from_sensor));
  const double rays_now = is_camera ? rays_per_rad(sensor.camera()) : rays_per_rad(sensor.lidar());
  const auto now = actors_during(scene.actors, frame.shot(), Eigen::Vector3d::Zero());
  const SupportTrust& trust = support_trust(is_camera ? SetKind::kCamera : SetKind::kLidar);
  std::vector<Expected> out;
  for (std::size_t i = 0; i < rays.rays; ++i) {
    Eigen::Vector3d d, origin = Eigen::Vector3d::Zero();
    if (is_camera) {
      const int width = sensor.camera().width;
      d = sensor.camera()
              .unproject({static_cast<int>(i) % width + 0.5, static_cast<int>(i) / width + 0.5})
              .normalized();
    } else {
      d = Lidar::direction(static_cast<double>(sensor.rays().azimuth[i]),
                           static_cast<double>(sensor.rays().elevation[i]));
      origin = ray_origin(sensor.lidar(), sensor.rays(), i);
    }
    d = world_from_sensor.rotation * d;
    const double opacity = 1.0 - static_cast<double>(rays.transmittance[i]);
    const double range = opacity > 0.5 ? static_cast<double>(rays.distance[i]) / opacity : kSupportFar_m;
    const Eigen::Vector3d p = world_from_sensor * origin + range * d;
    const Actor* on = nullptr;
    Pose actor_from_world;
    for (std::size_t a = 0; a < now.size() && on == nullptr && opacity > 0.5; ++a) {
      if (!now[a].is_there) continue;
      const Pose to = interpolate(now[a].scene_from_actor_start, now[a].scene_from_actor_end, 0.5).inverse();
      const Eigen::Vector3d q = to * p;
      if ((q.cwiseAbs().array() > 0.5 * scene.actors[a].size_m.array() + 0.1).any()) continue;
      on = &scene.actors[a];
      actor_from_world = to;
    }
    double looks = 0.0, angle = 2.0, finest = 0.0, weights = 0.0, error = 0.0, contrast = 0.0, edge = 0.0;
    for (const std::size_t v : views) {
      const SupportView& view = record.views[v];
      Pose view_from_world = view.world_from_view.inverse();
      if (on != nullptr) {
        const auto known = std::find_if(
            record.actors.begin(), record.actors.end(), [&](const Actor& a) { return a.name == on->name; });
        if (known == record.actors.end() || !known->is_there(view.time_s)) continue;
        view_from_world = view_from_world * known->at(view.time_s) * actor_from_world;
      }
      const Eigen::Vector3d y = view_from_world * p, e = view_from_world.rotation * d;
      const SupportGrid& grid = record.sensors[view.sensor].grid;
      const std::size_t cell = grid.cell_of(y);
      if (cell >= grid.cells()) continue;
      const SupportCell& c = record.cells[v * grid.cells() + cell];
      if (!(c.farthest_m > 0.0F)) continue;
      const double away = std::max(y.norm(), 1e-6), lo = static_cast<double>(c.nearest_m);
      const double hi = static_cast<double>(c.farthest_m);
      const double gap = std::max({lo * 0.97 - away, away - hi * 1.03, 0.0});
      const double share = std::min(gap / (away * 0.06), 1.0), has = std::pow(1.0 - share * share, 2);
      const double off = std::sqrt(std::max(2.0 - 2.0 * y.dot(e) / away, 0.0));
      const double scale = std::min(range * grid.rays_per_rad / rays_now / away, 1.0);
      const double along = 1.0 / (100.0 * off * off + 1.0);
      const double weight = has * (along * along * scale + 1e-3);
      looks += has;
      if (has > 0.5) angle = std::min(angle, off);
      finest = std::max(finest, has * scale);
      weights += weight;
      error += weight * static_cast<double>(c.log_error);
      contrast += weight * static_cast<double>(c.log_contrast);
      edge += weight * (hi - lo) / hi;
    }
    const double inv = 1.0 / std::max(weights, 1e-9);
    Expected one{.at_all = 1.0 - std::exp(-4.0 * looks)};
    one.odds = trust.constant + trust.angle * angle / (angle + 0.1) + trust.scale * finest +
               trust.error * error * inv + trust.contrast * contrast * inv + trust.edge * edge * inv;
    if (!is_camera) {
      const double drop = 1.0 / (1.0 + std::exp(-static_cast<double>(rays.drop_logit[i])));
      one.own_odds = trust.doubt * 4.0 * drop * (1.0 - drop) + trust.drop * drop;
      const double apart = opacity > 0.5 ? std::abs(static_cast<double>(rays.median[i]) - range) : 0.0;
      one.own_odds += trust.apart * apart / (apart + 0.01);
    }
    out.push_back(one);
  }
  return out;
}

Pose at_m(const Eigen::Vector3d& position_m, double yaw_rad = 0.0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), position_m};
}
Pose beside(double left_m, double yaw_rad) { return at_m({0.0, left_m, 0.0}, yaw_rad); }

/// Returns a shot of the sensor `left_m` to the left of at_origin().
Shot shot_beside(const Sensor& sensor, double left_m, double yaw_rad = 0.0) {
  Shot shot = at_origin(sensor);
  shot.world_from_sensor_start = beside(left_m, yaw_rad) * shot.world_from_sensor_start;
  shot.world_from_sensor_end = beside(left_m, yaw_rad) * shot.world_from_sensor_end;
  return shot;
}

SupportRecord recorded(SceneOnDevice& scene, const Sensor& sensor, const std::vector<double>& left_m) {
  SupportRecord record;
  record.actors = scene.scene().actors;
  for (const double left : left_m) {
    const Shot shot = shot_beside(sensor, left);
    add_view(record, scene.render(sensor, shot), shot.pose_at(0.5), 0.01 + 0.01 * std::abs(left));
  }
  return record;
}

double mean(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum / static_cast<double>(values.size());
}

SupportOnDevice on_device(const SceneOnDevice& scene, const SupportRecord& record) {
  return {scene.device(), std::make_shared<const SupportRecord>(record)};
}

class Support : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Sensor sensor() { return GetParam() ? still_camera() : still_lidar(); }
};

/// Tests the kernel against a sequential loop; `stack`: number of consecutive rows of 4 slots that share a
/// look-up.
void expect_as_sequential(const Sensor& recording, const Sensor& sensor, std::size_t stack) {
  RenderOptions twice;
  twice.precision = Precision::kDouble;
  for (const auto& [options, tolerance] : {std::pair{twice, 2e-4}, std::pair{RenderOptions{}, 2e-3}}) {
    SceneOnDevice scene(test::device(), wall_and_actor(), options);
    const SupportRecord record = recorded(scene, recording, {0.0, 0.3, -0.5, 1.0, -1.5});
    SupportOnDevice support = on_device(scene, record);
    const Frame frame = scene.render(sensor, shot_beside(sensor, 0.4, 0.1));
    const std::vector<float> found = support.of(frame, scene.scene());
    const std::vector<Expected> wanted = expected(record, frame, scene.scene());
    ASSERT_EQ(found.size(), wanted.size());
    std::size_t off = 0, known = 0, compared = 0;
    const RayGrid& grid = FrameAccess::grid(frame);
    const auto ray_at = [&](std::size_t slot) { return grid.ray_of_slot[slot]; };
    for (std::size_t run = 0; run < grid.ray_of_slot.size(); run += 4 * stack) {
      // The second slot of the middle row is looked up, or else the first slot with a ray.
      std::vector<std::size_t> slots(4 * stack);
      std::iota(slots.begin(), slots.end(), run);
      std::size_t reporting = slots[stack / 2 * 4 + 1];
      for (std::size_t k = 0; k < slots.size() && ray_at(reporting) < 0; ++k) reporting = slots[k];
      if (ray_at(reporting) < 0) continue;
      const Expected& reported = wanted[static_cast<std::size_t>(ray_at(reporting))];
      std::size_t run_off = 0;
      for (const std::size_t slot : slots) {
        if (ray_at(slot) < 0) continue;
        const auto i = static_cast<std::size_t>(ray_at(slot));
        const double trusted = wanted[i].support(reported);
        run_off += std::abs(static_cast<double>(found[i]) - trusted) > tolerance ? 1 : 0;
        known += trusted > 0.01 ? 1 : 0;
        ++compared;
      }
      off += run_off > 0 ? 1 : 0;
    }
    EXPECT_EQ(compared, found.size());
    // At the edge of a cell the two may use neighbouring cells.
    EXPECT_LE(off * stack, found.size() / 50);
    EXPECT_GT(known, found.size() / 20);
  }
}

TEST_P(Support, IsThatOfASequentialLoopInDouble) { expect_as_sequential(sensor(), sensor(), 1); }

TEST(SupportOfFinerPictures, IsLookedUpFourTimesInACell) {
  const Sensor recording = still_camera();
  const auto of_size = [&](int width, int height) {
    return Sensor(recording.camera().resized(width, height), recording.rig_from_sensor());
  };
  expect_as_sequential(recording, of_size(36, 24), 1);
  expect_as_sequential(recording, of_size(72, 48), 2);
  expect_as_sequential(recording, of_size(96, 64), 4);
  // More than four times; its last tiles are partial.
  expect_as_sequential(recording, of_size(201, 131), 4);
}

TEST(SupportOfHoles, IsNoneThoughAPictureBeforeHadSome) {
  const auto fisheye = [](double max_angle_rad) {
    Camera camera = still_camera().camera();
    camera.lens = Lens(LensKind::kOpencvFisheye, {0.0, 0.0, 0.0, 0.0, max_angle_rad});
    return Sensor(camera, still_camera().rig_from_sensor());
  };
  const Sensor whole = fisheye(1.2), narrow = fisheye(0.3);
  SceneOnDevice scene(test::device(), wall_and_actor());
  SupportOnDevice support = on_device(scene, recorded(scene, whole, {0.0}));
  const std::vector<float> before = support.of(scene.render(whole, at_origin(whole)), scene.scene());
  const std::vector<float> found = support.of(scene.render(narrow, at_origin(narrow)), scene.scene());
  std::size_t known = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int width = narrow.camera().width, x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    if (!narrow.camera().unproject({x + 0.5, y + 0.5}).isZero(0.0)) continue;
    EXPECT_EQ(found[i], 0.0F) << i;
    known += before[i] > 0.0F ? 1 : 0;
  }
  EXPECT_GT(known, 100U);
}

TEST_P(Support, OfAFrameStaysWhenOthersAskForOtherRaysOfItsSensor) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  SupportOnDevice support = on_device(scene, recorded(scene, sensor(), {0.0, 0.3, -0.5}));
  const Frame frame = scene.render(sensor(), at_origin(sensor()));
  const std::vector<float> before = support.of(frame, scene.scene());
  std::vector<bool> half(sensor().ray_count(), false);
  std::fill(half.begin(), half.begin() + static_cast<std::ptrdiff_t>(half.size() / 2), true);
  const Frame part = scene.render(sensor(), at_origin(sensor()), {.rays = half});
  EXPECT_EQ(support.of(frame, scene.scene()), before);
  const std::vector<float> of_part = support.of(part, scene.scene());
  (void)scene.render(sensor(), at_origin(sensor()));
  EXPECT_EQ(support.of(part, scene.scene()), of_part);
  EXPECT_NE(of_part, before);
}

TEST_P(Support, RisesWithLooks) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Frame frame = scene.render(sensor(), at_origin(sensor()));
  double last = 0.0;
  for (std::size_t looks = 1; looks <= kMostSupportViews; looks *= 2) {
    const double now = mean(on_device(scene, recorded(scene, sensor(), std::vector<double>(looks, 0.0)))
                                .of(frame, scene.scene()));
    EXPECT_GT(now, last) << looks;
    last = now;
  }
}

TEST_P(Support, FallsWithAngleAndError) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  SupportOnDevice support = on_device(scene, recorded(scene, sensor(), {0.0, 0.0, 0.0}));
  const double here = mean(support.of(scene.render(sensor(), at_origin(sensor())), scene.scene()));
  EXPECT_GT(here, mean(support.of(scene.render(sensor(), shot_beside(sensor(), 1.0)), scene.scene())));
  SupportRecord wrong = recorded(scene, sensor(), {0.0, 0.0, 0.0});
  for (SupportCell& cell : wrong.cells) cell.log_error += 2.0F;
  EXPECT_GT(here,
            mean(on_device(scene, wrong).of(scene.render(sensor(), at_origin(sensor())), scene.scene())));
}

TEST_P(Support, IsNoneWhereNothingWasRecorded) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Frame frame = scene.render(sensor(), at_origin(sensor()));
  const auto all_zero = [&](const SupportRecord& record) {
    const std::vector<float> found = on_device(scene, record).of(frame, scene.scene());
    return std::all_of(found.begin(), found.end(), [](float v) { return v == 0.0F; });
  };
  SupportRecord record = recorded(scene, sensor(), {0.0});
  EXPECT_FALSE(all_zero(record));
  SupportRecord hidden = record;  // by an object in front of all
  for (SupportCell& cell : hidden.cells) cell.nearest_m = cell.farthest_m = 0.2F;
  EXPECT_TRUE(all_zero(hidden));
  SupportRecord blind = record;
  for (SupportCell& cell : blind.cells) cell = {};
  EXPECT_TRUE(all_zero(blind));
  EXPECT_TRUE(all_zero({}));
}

TEST_P(Support, LeavesTheFrameAsItIs) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  SupportOnDevice support = on_device(scene, recorded(scene, sensor(), {0.0}));
  const Frame with = scene.render(sensor(), at_origin(sensor()));
  (void)support.of(with, scene.scene());
  const Frame without = scene.render(sensor(), at_origin(sensor()));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(with.results().feature[k], without.results().feature[k]);
  EXPECT_EQ(with.results().transmittance, without.results().transmittance);
  EXPECT_EQ(with.results().distance, without.results().distance);
  EXPECT_EQ(support.of(with, scene.scene()), support.of(without, scene.scene()));
}

INSTANTIATE_TEST_SUITE_P(Of, Support, testing::Bool(), [](const auto& of) {
  return of.param ? "ACamera" : "ALidar";
});

TEST(SupportOfActors, GoesWithThemAndTheirCopies) {
  SceneOnDevice scene(test::device(), wall_and_actor());
  const Sensor camera = still_camera().resized(192, 128);  // wide enough for runs of four
  const SupportRecord record = recorded(scene, camera, {0.0, 0.0});
  SupportOnDevice support = on_device(scene, record);
  FrameRequest request{.camera_median = true, .actors = true};
  const auto of_actors = [&](const Scene& shown, const Shot& shot, const ActorCopies& copies) {
    scene.set_scene(shown);
    const Frame frame = scene.render(camera, shot, request);
    const std::vector<std::uint32_t> actors = frame.actors();
    const std::vector<float> all = support.of(frame, shown, copies);
    std::vector<float> own;
    for (std::size_t i = 0; i < all.size(); ++i) {
      // At its soft edge the mean distance is between the actor and the wall.
      if (actors[i] != 0 && frame.results().expected_distance(i) < 5.8F) own.push_back(all[i]);
    }
    if (own.empty()) return -1.0;
    std::sort(own.begin(), own.end());
    return static_cast<double>(own[own.size() / 2]);
  };
  const Scene as_recorded = scene.scene();
  const double still = of_actors(as_recorded, at_origin(camera), {});
  EXPECT_GT(still, 0.3);
  // Another name: support of an unknown object, unless it is registered as a copy.
  Scene renamed = as_recorded;
  for (Actor& actor : renamed.actors) actor.name += "_2";
  EXPECT_LT(of_actors(renamed, at_origin(camera), {}), 0.05);
  ActorCopies copies;
  for (const Actor& actor : as_recorded.actors) copies[actor.name + "_2"] = actor.name;
  EXPECT_NEAR(of_actors(renamed, at_origin(camera), copies), still, 1e-6);
  // Rotated by 180 degrees, it shows an unrecorded side.
  Shot turned = at_origin(camera);
  for (const Actor& actor : as_recorded.actors) turned.edits.push_back({actor.name, ActorEdit::Turn{2.5}});
  EXPECT_LT(of_actors(as_recorded, turned, {}), 0.8 * still);
}

TEST(SupportOnDevice, NeedsARecord) {
  try {
    const SupportOnDevice none(test::device(), nullptr);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("train it anew"), std::string::npos);
  }
}

TEST(SupportViews, OfARigsCamerasLookTheSameWay) {
  SupportRecord record;
  constexpr std::size_t kCameras = 6;
  for (std::size_t c = 0; c < kCameras; ++c)
    record.sensors.push_back({std::to_string(c), SetKind::kCamera, {}});
  for (std::size_t i = 0; i < 20 * kCameras; ++i) {
    const double yaw_rad = static_cast<double>(i % kCameras) * 2.0 * std::numbers::pi / kCameras;
    const Eigen::Vector3d position_m(0.3 * static_cast<double>(i / kCameras), 0.0, 0.0);
    record.views.push_back(
        {i % kCameras, 0.1 * static_cast<double>(i / kCameras), at_m(position_m, yaw_rad)});
  }
  // Between the directions of two views, nearer to one of them.
  const double yaw_rad = 2.4 * 2.0 * std::numbers::pi / kCameras;
  const auto views = support_views_around(record, SetKind::kCamera, at_m({3.0, 0.0, 0.0}, yaw_rad));
  ASSERT_EQ(views.size(), kMostSupportViews);
  EXPECT_EQ(record.views[views.front()].sensor, 2U);
  for (const std::size_t v : views) {
    EXPECT_TRUE(record.views[v].sensor == 2 || record.views[v].sensor == 3) << record.views[v].sensor;
    EXPECT_LT(std::abs(record.views[v].world_from_view.translation.x() - 3.0), 2.5);
  }
}

TEST(SupportViews, OfALidarAreThoseNearbyAndSomeOfTheOthers) {
  SupportRecord record;
  record.sensors = {{"camera", SetKind::kCamera, {}}, {"lidar", SetKind::kLidar, {}}};
  for (std::size_t i = 0; i < 200; ++i) {
    const auto x_m = static_cast<double>(i);
    record.views.push_back({i % 2, 0.1 * x_m, {Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}}});
  }
  const auto views = support_views_around(record, SetKind::kLidar, at_m({100.0, 0.0, 0.0}));
  ASSERT_EQ(views.size(), kMostSupportViews);
  std::size_t near = 0;
  for (const std::size_t v : views) {
    EXPECT_EQ(record.views[v].sensor, 1U);
    near += std::abs(static_cast<double>(v) - 100.0) < 12.5 ? 1 : 0;
  }
  EXPECT_GE(near, kMostSupportViews / 2);
  EXPECT_LT(near, kMostSupportViews);
  EXPECT_TRUE(std::any_of(views.begin(), views.end(), [](std::size_t v) { return v < 30 || v > 170; }));
}

}  // namespace
}  // namespace simuli
