// Tests per-ray orders with a window (render.window): a wide window is exact, and rays that exceed a window
// are computed again exactly.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/render/actor_scenes.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace render_window_test {

using test::SceneCase;

test::Shot shot_for(const SceneCase& scene) {
  test::Shot shot =
      scene.kind == SetKind::kCamera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);
  shot.view.drop = test::some_ray_drop(3);
  return shot;
}

/// Wide overlapping particles: the order by range often differs from the order along a ray.
GaussianSet crowd(const SceneCase& scene, Eigen::Index count) {
  const test::SetRecipe recipe{.count = count,
                               .low = {-12, -12, -4},
                               .high = {12, 12, 4},
                               .scale_min = 0.05,
                               .scale_max = 1.8,
                               .opacity_max = 0.6};
  return test::set_for(scene, recipe, 7);
}

RenderOptions options_with(Order order, int window) {
  RenderOptions options = paper_options();
  options.order = order;
  options.window = window;
  return options;
}

RayResults render(const GaussianSet& set, const test::Shot& shot, const RenderOptions& options) {
  const Device& device = test::device();
  Renderer renderer(device, options);
  return renderer.render(ParticleBuffers(device, set, options), shot.on(device, options), shot.view)
      .results();
}

std::vector<reference::RayResult> reference_of(const GaussianSet& set,
                                               const test::Shot& shot,
                                               bool per_ray_features = false) {
  reference::Options twin;
  twin.per_ray_order = true;
  twin.per_ray_features = per_ray_features;
  const auto& background = shot.view.background;
  return reference::render(reference::Particles(set),
                           shot.reference(),
                           twin,
                           {static_cast<double>(background[0]),
                            static_cast<double>(background[1]),
                            static_cast<double>(background[2])});
}

void expect_same_bits(const RayResults& a, const RayResults& b) {
  for (int k = 0; k < 3; ++k) EXPECT_EQ(a.feature[k], b.feature[k]);
  EXPECT_EQ(a.transmittance, b.transmittance);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.median, b.median);
  EXPECT_EQ(a.drop_logit, b.drop_logit);
}

/// Returns the RMS difference of colours, or of intensity and logits.
double apart(const RayResults& a, const RayResults& b) {
  double square = 0.0;
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < a.rays; ++i) {
      square += std::pow(static_cast<double>(a.feature[k][i]) - static_cast<double>(b.feature[k][i]), 2);
    }
  }
  return std::sqrt(square / (3.0 * static_cast<double>(a.rays)));
}

struct WindowCase {
  SceneCase scene;
  Precision precision;
  LaneShape shape;
  ShDirection direction;
};
void PrintTo(const WindowCase& c, std::ostream* out) { PrintTo(c.scene, out); }

class Window : public testing::TestWithParam<WindowCase> {
 protected:
  void SetUp() override {
    if (GetParam().precision == Precision::kDouble) SIMULI_NEEDS_DOUBLE(test::device());
    SIMULI_NEEDS_WINDOWS(test::device(), GetParam().shape);
  }
  [[nodiscard]] static RenderOptions options_of_case(Order order, int window) {
    RenderOptions options = options_with(order, window);
    options.precision = GetParam().precision;
    options.shape = GetParam().shape;
    options.sh_direction = GetParam().direction;
    return options;
  }
};

// Few particles: 64 entries contain all particles of neighbouring rays.
TEST_P(Window, OfAllEntriesMatchesTheReference) {
  const SceneCase& scene = GetParam().scene;
  const GaussianSet set = crowd(scene, 64);
  const test::Shot shot = shot_for(scene);
  const RayResults results = render(set, shot, options_of_case(Order::kWindow, 64));
  const bool is_double = GetParam().precision == Precision::kDouble;
  const test::Tolerance& tolerance = is_double ? test::kDoubleTolerance : test::kFloatTolerance;
  const auto expected = reference_of(set, shot, GetParam().direction == ShDirection::kRay);
  EXPECT_GT(test::expect_same_rays(results, expected, scene.kind, tolerance).compared,
            is_double ? 0.98 : 0.2);
  test::expect_drop_logits(results, shot.view, scene.kind);
  expect_same_bits(results, render(set, shot, options_of_case(Order::kPerRay, 64)));
}

// Vectors that exceed the window are computed again: the width only changes their number.
TEST_P(Window, WidthIsNoMatterToExactOrder) {
  const SceneCase& scene = GetParam().scene;
  const GaussianSet set = crowd(scene, 600);
  const test::Shot shot = shot_for(scene);
  const RayResults exact = render(set, shot, options_of_case(Order::kPerRay, 2));
  expect_same_bits(render(set, shot, options_of_case(Order::kPerRay, 64)), exact);
  const double by_range = apart(render(set, shot, options_of_case(Order::kRange, 2)), exact);
  const double narrow = apart(render(set, shot, options_of_case(Order::kWindow, 2)), exact);
  const double wide = apart(render(set, shot, options_of_case(Order::kWindow, 64)), exact);
  EXPECT_GT(narrow, 0.0);
  EXPECT_LT(narrow, by_range);
  EXPECT_LT(wide, 0.5 * narrow);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    Window,
    testing::Values(
        WindowCase{test::kCameraSh3, Precision::kDouble, test::kDefaultShape, ShDirection::kRay},
        WindowCase{test::kCameraStill, Precision::kFloat, test::kCpuShape, ShDirection::kParticle},
        WindowCase{test::kCameraStill, Precision::kFloat, test::kGpuShape, ShDirection::kParticle},
        WindowCase{test::kLidarMoving, Precision::kFloat, test::kCpuShape, ShDirection::kRay}),
    [](const auto& pair) {
      const WindowCase& c = pair.param;
      return std::string(c.scene.name) + (c.precision == Precision::kFloat ? "_float" : "_double") +
             "_lanes" + std::to_string(c.shape.lanes);
    });

// A plate 9.5 m away extends through a wall to 3.6 m: rays that terminate at the wall intersect the plate
// first.
TEST(PerRayOrder, HoldsForWhatIsMetAfterARaysEnd) {
  std::vector<test::SingleParticle> particles;
  for (int i = 0; i < 12; ++i) {
    particles.push_back({.mean = {5.0 + 0.1 * i, 0.0, 0.0}, .scale = {0.05, 6.0, 6.0}, .opacity = 0.97});
  }
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::atan(1.8), Eigen::Vector3d::UnitZ()));
  particles.push_back({.mean = {9.0, -3.0, 0.0},
                       .scale = {0.05, 4.0, 4.0},
                       .rotation = turn,
                       .opacity = 0.9,
                       .feature = {0.9, 0.1, 0.2}});
  const GaussianSet set = test::set_of(SetKind::kCamera, particles);
  const test::Shot shot = shot_for(test::kCameraStill);
  const auto expected = reference_of(set, shot);
  for (const LaneShape& shape : {test::kCpuShape, test::kGpuShape}) {
    RenderOptions options = options_with(Order::kPerRay, 2);
    options.shape = shape;
    const RayResults results = render(set, shot, options);
    EXPECT_GT(test::expect_same_rays(results, expected, SetKind::kCamera, test::kFloatTolerance).compared,
              0.2);
    options.order = Order::kWindow;
    EXPECT_GT(apart(render(set, shot, options), results), 0.01);
  }
}

// Particles of moving actors are at their position at each ray's time in both orders.
TEST(PerRayOrder, HoldsForActorsInMotion) {
  for (const SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    GaussianSet set = crowd(scene, 300);
    set.actor.resize(300);
    for (Eigen::Index i = 0; i < 300; ++i) {
      set.actor[static_cast<std::size_t>(i)] = i % 3 == 0 ? 0U : static_cast<std::uint32_t>(i % 3);
    }
    test::Shot shot = shot_for(scene);
    shot.view.actors = test::cars(0.9, 0.08);
    const RayResults exact = render(set, shot, options_with(Order::kPerRay, 2));
    expect_same_bits(render(set, shot, options_with(Order::kPerRay, 64)), exact);
    const double by_range = apart(render(set, shot, options_with(Order::kRange, 2)), exact);
    EXPECT_LT(apart(render(set, shot, options_with(Order::kWindow, 64)), exact), 0.5 * by_range);
  }
}

TEST(WindowWidth, IsCheckedByKey) {
  for (const int window : {1, 65}) {
    expect_error(ErrorKind::kUsage, "render.window: found", [&] {
      Renderer(test::device(), options_with(Order::kWindow, window));
    });
  }
}

}  // namespace render_window_test
}  // namespace simuli
