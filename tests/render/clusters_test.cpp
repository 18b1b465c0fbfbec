// Tests that frames without clusters outside the view have equal bits, for all sensors and for particles at
// the limits of the decision.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "bench/particles/particle_street.hpp"
#include "host/core/base/angles.hpp"
#include "host/core/scene/particle_order.hpp"
#include "host/device/render/frame/actor_constants.hpp"
#include "host/device/render/pages/frame_sight.hpp"
#include "host/device/render/scene/sensor_in_frame.hpp"
#include "tests/cl/support.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::SceneCase;
using test::Shot;

constexpr Eigen::Index kClusters = 96;

/// Moves 3.2 m and rotates by 12 degrees during the frame.
void set_moving(View& view) {
  view.scene_from_sensor_end.translation =
      view.scene_from_sensor_start.translation + Vector3d(3.0, -1.0, 0.2);
  view.scene_from_sensor_end.rotation = view.scene_from_sensor_start.rotation *
                                        Eigen::AngleAxisd(kPi / 15.0, Vector3d(0.05, 1.0, 0.1).normalized());
}

/// Returns the maximum range of a sensor; cameras have no limit, particles are placed up to this distance.
double farthest_m(const Shot& shot) { return shot.kind == SetKind::kCamera ? 300.0 : shot.lidar.range_max; }

/// Returns clusters that fill a ball, some up to its surface, or are at the limit of visibility: beside the
/// cone of a picture, or beyond a LiDAR's range. Means of an actor's cluster are in the actor's frame.
GaussianSet close_calls(const SceneCase& scene, const Shot& shot, double view_angle, std::uint64_t seed) {
  test::Random random(seed);
  const Pose scene_from_sensor =
      interpolate(shot.view.scene_from_sensor_start, shot.view.scene_from_sensor_end, 0.5);
  GaussianSet set(scene.kind, scene.sh_degree, kClusters * SIM_CLUSTER);
  const auto decades = [&](double low, double high) {
    return std::exp(random.uniform(std::log(low), std::log(high)));
  };
  for (Eigen::Index c = 0; c < kClusters; ++c) {
    const double farthest = farthest_m(shot);
    double range = decades(0.02, 3.0 * farthest);
    const double scale = range * decades(1e-5, c % 7 == 0 ? 3.0 : 0.03);
    const double spread = c % 3 == 0 ? 0.0 : range * decades(1e-4, 1.0);
    Vector3d direction = random.direction();
    const double reach = scale * std::sqrt(2.0 * std::log(0.9 * 255.0));
    if (c % 2 == 0) {  // just inside or outside
      const double off = random.uniform(-0.02, 0.02);
      if (scene.kind == SetKind::kCamera) {
        const double angle = view_angle + std::asin(std::min(reach / range, 1.0)) + off;
        const double around = random.uniform(0.0, 2.0 * kPi);
        direction = {std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle)};
      } else {
        range = farthest * (1.0 + off) + reach;
      }
    }
    const Vector3d place = scene_from_sensor * Vector3d(range * direction);
    const std::uint32_t actor = shot.view.actors.empty() ? 0U : static_cast<std::uint32_t>(c % 5);
    for (Eigen::Index k = 0; k < SIM_CLUSTER; ++k) {
      const Eigen::Index i = c * SIM_CLUSTER + k;
      Vector3d mean = place + spread * random.direction() * random.uniform(0.0, 1.0);
      if (!shot.view.actors.empty()) {
        // Every fifth cluster belongs to several actors.
        set.actor.push_back(actor == 4 ? static_cast<std::uint32_t>(k % 4) : actor);
        if (const std::uint32_t own = set.actor.back(); own > 0) {
          const ActorView& view = shot.view.actors[own - 1];
          mean = interpolate(view.scene_from_actor_start, view.scene_from_actor_end, 0.5).inverse() * mean;
        }
      }
      const Eigen::Quaterniond turn = random.rotation();
      set.mean().row(i) = mean.transpose().cast<float>();
      set.rotation().row(i) << static_cast<float>(turn.w()), static_cast<float>(turn.x()),
          static_cast<float>(turn.y()), static_cast<float>(turn.z());
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        set.log_scale()(i, axis) =
            static_cast<float>(std::log(scale * (axis == k % 3 ? 1.0 : random.uniform(0.01, 1.0))));
      }
      // In some clusters nearly all particles are too faint, in some all.
      const double opacity = c % 11 == 5      ? random.uniform(0.001, c % 2 == 1 ? 0.0039 : 0.0041)
                             : k % 5 == c % 5 ? 0.9
                                              : 0.02;
      set.opacity_logit()(i) = static_cast<float>(std::log(opacity / (1.0 - opacity)));
      set.sh(0).row(i).setConstant(static_cast<float>(random.uniform(-1.0, 1.0)));
    }
  }
  return set;
}

/// Sets some parameters to non-finite or unusable values.
void spoil(GaussianSet& set, std::uint64_t seed) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const std::vector<float> odd{std::nanf(""), kInf, -kInf, 3e38F, -3e38F, 1e19F, 85.0F, -85.0F, 0.0F};
  test::Random random(seed);
  for (Eigen::Index c = 0; c < kClusters; c += 2) {
    const auto within = static_cast<Eigen::Index>(random.uniform(0.0, SIM_CLUSTER));
    const auto row = static_cast<Eigen::Index>(random.uniform(0.0, kShRow));
    set.params(c * SIM_CLUSTER + within, row) =
        odd[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(odd.size())))];
  }
}

struct Seen {
  std::vector<std::uint32_t> keys;  // of all particles
  std::vector<double> out;          // all outputs of blending
  std::vector<std::uint32_t> live;  // of all clusters
  std::size_t clusters_left_out = 0;
};
Seen seen_of(Renderer& renderer, const ParticleBuffers& particles, const SensorRays& rays, const View& view) {
  const Pass pass = renderer.render(particles, rays, view);
  Seen seen{pass.buffers().projected.keys.download(),
            test::outputs(pass),
            pass.buffers().projected.live.download(),
            0};
  seen.keys.resize(particles.count);
  seen.live.resize((particles.count + SIM_CLUSTER - 1) / SIM_CLUSTER);
  seen.clusters_left_out = static_cast<std::size_t>(std::count(seen.live.begin(), seen.live.end(), 0U));
  return seen;
}

/// Returns whether the host, which selects the data on the device, considers each cluster visible.
std::vector<bool> in_sight(const GaussianSet& set,
                           const SensorRays& rays,
                           const View& view,
                           const RenderOptions& options) {
  const SensorInFrame sensor =
      sensor_in_frame(rays, view.scene_from_sensor_start, view.scene_from_sensor_end, options, {}, view.drop);
  bool motion = false;
  const std::vector<double> actors =
      actor_constants(view.actors, Vector3d(sensor.constants.centre_ref), motion);
  const FrameSight sight(rays.grid().type, sensor.constants, false, actors);
  const ParticleClusters clusters = clusters_of(set);
  std::vector<bool> seen;
  for (Eigen::Index c = 0; c * SIM_CLUSTER < set.size(); ++c) {
    seen.push_back(sight.may_see(ParticleBounds::of(clusters, static_cast<std::size_t>(c))));
  }
  return seen;
}

/// Compares frames with all particles with frames without invisible clusters.
class Clusters : public testing::Test {
 protected:
  void expect_same(Renderer& renderer, const GaussianSet& set, const SensorRays& rays, const View& view) {
    const RenderOptions& options = renderer.options();
    const Seen all = seen_of(renderer, ParticleBuffers(device_, set, options.precision), rays, view);
    const Seen some = seen_of(renderer, ParticleBuffers(device_, set, options), rays, view);
    ASSERT_EQ(all.clusters_left_out, 0U);
    ASSERT_EQ(some.keys, all.keys);
    ASSERT_EQ(some.out.size(), all.out.size());
    ASSERT_EQ(std::memcmp(some.out.data(), all.out.data(), all.out.size() * sizeof(double)), 0);
    left_out_ += some.clusters_left_out;
    const std::vector<bool> sight = in_sight(set, rays, view, options);
    for (std::size_t c = 0; c < some.live.size(); ++c) {
      ASSERT_LE(some.live[c], sight[c] ? 1U : 0U) << "cluster " << c;
      out_of_sight_ += sight[c] ? 0U : 1U;
    }
    for (std::size_t first = 0; first < all.keys.size(); first += SIM_CLUSTER) {
      const auto begin = all.keys.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end =
          all.keys.begin() + static_cast<std::ptrdiff_t>(std::min(first + SIM_CLUSTER, all.keys.size()));
      unseen_ += std::all_of(begin, end, [](std::uint32_t key) { return key == 0xffffffffU; }) ? 1U : 0U;
    }
  }

  /// Tests clusters at the limits, valid and with unusable parameters, and the street.
  void expect_same(const SceneCase& scene, const Shot& shot, const RenderOptions& options = {}) {
    SCOPED_TRACE(scene.name);
    Renderer renderer(device_, options);
    const SensorRays rays = shot.on(device_, renderer.options());
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      GaussianSet set = close_calls(scene, shot, rays.grid().view_angle, seed);
      expect_same(renderer, set, rays, shot.view);
      if (HasFatalFailure()) return;
      spoil(set, seed);
      expect_same(renderer, set, rays, shot.view);
      if (HasFatalFailure()) return;
    }
    std::cout << scene.name << ": " << left_out_ << " of " << unseen_ << " unseen clusters left out\n";
    EXPECT_GT(left_out_, unseen_ / 20);  // otherwise nothing is tested
    EXPECT_GE(20 * out_of_sight_, 19 * left_out_);
    left_out_ = unseen_ = out_of_sight_ = 0;
  }

  Device device_ = test::device();
  std::size_t left_out_ = 0, unseen_ = 0, out_of_sight_ = 0;
};

Shot small_shot(const SceneCase& scene) {
  return scene.kind == SetKind::kCamera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);
}

TEST_F(Clusters, ChangeNoBitOfAnySensor) {
  for (const SceneCase& scene :
       {test::kCameraStill, test::kCameraRolling, test::kLidarLevers, test::kLidarMoving}) {
    Shot shot = small_shot(scene);
    if (scene.moving) set_moving(shot.view);
    expect_same(scene, shot);
  }
}

TEST_F(Clusters, ChangeNoBitThroughAnyLens) {
  const auto through =
      [this](const char* name, LensKind kind, const std::vector<double>& parameters, double focal) {
        SceneCase scene = test::kCameraRolling;
        scene.name = name;
        Shot shot = small_shot(scene);
        set_moving(shot.view);
        shot.camera.fx = shot.camera.fy = focal;
        shot.camera.lens = Lens(kind, parameters);
        expect_same(scene, shot);
      };
  through("pinhole, distorted",
          LensKind::kOpencvPinhole,
          {-0.2, 0.05, 0.001, -0.001, 0, 0, 0, 0, 0, 0, 0, 0, kPi},
          60);
  // shows directions to the rear
  through("fisheye", LensKind::kOpencvFisheye, {0.004, 0.002, 0.0, 0.0005, 1.95}, 20);
  through("F-theta", LensKind::kFtheta, {1.0, -0.02, 0.06, -0.095, 0.034, 1.0, 0.0, 0.0, 1.35}, 30);
  through(
      "F-theta, inverse", LensKind::kFthetaInverse, {1.0, 0.03, -0.08, 0.11, -0.03, 1.0, 0.0, 0.0, 1.3}, 30);
  through("MEI", LensKind::kMei, {0.017, 0.1, 0.0004, 0.0004, 1.2, 2.0}, 30);
  through("equirectangular", LensKind::kEquirectangular, {}, 72 / (2 * kPi));
  through("double sphere", LensKind::kDoubleSphere, {-0.17, 0.593, 1.2}, 30);
  through("EUCM", LensKind::kEucm, {0.63, 1.04, 1.2}, 30);
}

TEST_F(Clusters, ChangeNoBitWithActors) {
  for (const SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    Shot shot = small_shot(scene);
    set_moving(shot.view);
    shot.view.actors = test::cars(4.0, 0.5);
    shot.view.actors.push_back(shot.view.actors.front());
    shot.view.actors.back().is_there = false;
    expect_same(scene, shot);
    // An actor whose shape extends by metres.
    DeformationView& shape = shot.view.actors[1].deformation;
    shape.nodes = {2, 3, 2};
    shape.half_m = {2.0, 1.0, 0.8};
    test::Random random(4);
    for (std::vector<double>* const offsets : {&shape.start_m, &shape.end_m}) {
      for (int i = 0; i < 36; ++i) offsets->push_back(random.uniform(-3.0, 3.0));
    }
    expect_same(scene, shot);
  }
}

TEST_F(Clusters, ChangeNoBitInOtherShapesAndWithCompensation) {
  RenderOptions gpu, compensated;
  gpu.shape = test::kGpuShape;
  compensated.camera_compensation = compensated.lidar_compensation = true;
  expect_same(test::kCameraStill, small_shot(test::kCameraStill), gpu);
  expect_same(test::kLidarStill, small_shot(test::kLidarStill), gpu);
  expect_same(test::kCameraStill, small_shot(test::kCameraStill), compensated);
}

TEST_F(Clusters, ChangeNoBitInDouble) {
  SIMULI_NEEDS_DOUBLE(device_);
  RenderOptions options;
  options.precision = Precision::kDouble;
  expect_same(test::kCameraStill, small_shot(test::kCameraStill), options);
  expect_same(test::kLidarStill, small_shot(test::kLidarStill), options);
}

TEST_F(Clusters, ChangeNoBitOfRequestedRays) {
  RenderOptions options;
  const Shot shot = small_shot(test::kLidarStill);
  Renderer renderer(device_, options);
  const SensorRays rays = shot.on(device_, renderer.options());
  std::vector<bool> requested(rays.grid().rays, false);
  for (std::size_t i = 0; i < requested.size(); i += 7) requested[i] = true;
  expect_same(renderer, close_calls(test::kLidarStill, shot, 0.0, 4), rays.requested(requested), shot.view);
}

TEST_F(Clusters, ChangeNoGradient) {
  const Shot shot = small_shot(test::kCameraStill);
  Renderer renderer(device_, {});
  const SensorRays rays = shot.on(device_, renderer.options());
  const GaussianSet set = close_calls(test::kCameraStill, shot, rays.grid().view_angle, 5);
  const auto gradients = [&](const ParticleBuffers& particles) {
    RealBuffer grads(device_, "parameter gradients", Precision::kFloat);
    grads.reserve(particles.params.count());
    grads.fill(1.0);
    Pass pass = renderer.render(particles, rays, shot.view);
    pass.set_output_gradients(std::vector<double>(5 * rays.grid().rays, 1e-2));
    pass.backward(particles, grads);
    return grads.download_float();
  };
  EXPECT_EQ(gradients(ParticleBuffers(device_, set, renderer.options())),
            gradients(ParticleBuffers(device_, set, Precision::kFloat)));
}

TEST_F(Clusters, OfFewParticlesAndOfNone) {
  const Shot shot = small_shot(test::kCameraStill);
  Renderer renderer(device_, {});
  const SensorRays rays = shot.on(device_, renderer.options());
  const GaussianSet street = street_particles(SetKind::kCamera, 0, 1025, 1);
  for (const Eigen::Index count : {1025, 1, 0, 257, 256, 255, 17}) {
    GaussianSet set(SetKind::kCamera, 0, count);
    set.params = street.params.topRows(count);
    expect_same(renderer, set, rays, shot.view);
    if (HasFatalFailure()) return;
  }
}

TEST_F(Clusters, OfALongStreetAreMostlyLeftOut) {
  const SceneCase scene = test::kLidarStill;
  const Shot shot = small_shot(scene);
  Renderer renderer(device_, {});
  const SensorRays rays = shot.on(device_, renderer.options());
  expect_same(renderer,
              street_particles(SetKind::kLidar, scene.sh_degree, 60'000, 1, StreetOrder::kCoherent, 1600.0),
              rays,
              shot.view);
  EXPECT_GT(left_out_, std::size_t{60'000 * 8 / 10 / SIM_CLUSTER});  // 160 of 1600 m are in range
}

}  // namespace
}  // namespace simuli
