// Tests bilateral grids: forward against a sequential loop in double, gradients against difference quotients.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <vector>

#include "host/device/render/backward/backward_stages.hpp"
#include "tests/cl/support.hpp"
#include "tests/render/gradient/gradient_check.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr double kGradientTolerance = 1e-6;

class ColorGrid : public testing::TestWithParam<Precision> {
 protected:
  Device device_ = test::device();
};

/// Two grids near the identity.
ColorGrids random_grids(int x, int y, int z) {
  ColorGrids grids = ColorGrids::identity(x, y, z, {{"front", 0.0}, {"front", 1.0}});
  test::Random random(13);
  for (float& value : grids.values) value += static_cast<float>(0.2 * random.normal());
  return grids;
}

/// Returns one colour through grid `index` at pixel (px, py), from the definition.
double graded(const ColorGrids& grids,
              std::size_t index,
              const Camera& camera,
              int px,
              int py,
              const double* rgb,
              std::size_t channel) {
  const double luminance = std::clamp(0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2], 0.0, 1.0);
  const double place[3] = {(px + 0.5) / camera.width * (grids.size_x - 1),
                           (py + 0.5) / camera.height * (grids.size_y - 1),
                           luminance * (grids.size_z - 1)};
  const int size[3] = {grids.size_x, grids.size_y, grids.size_z};
  double out = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    int at[3];
    for (unsigned k = 0; k < 3; ++k) {
      const int low = std::min(static_cast<int>(place[k]), size[k] - 2);
      const bool upper = (corner >> k & 1U) != 0;
      at[k] = low + (upper ? 1 : 0);
      weight *= upper ? place[k] - low : 1.0 - (place[k] - low);
    }
    const std::size_t vertex =
        static_cast<std::size_t>((at[1] * grids.size_x + at[0]) * grids.size_z + at[2]);
    const float* m =
        grids.values.data() + index * grids.values_per_frame() + vertex * ColorGrids::kMatrix + 4 * channel;
    out += weight * (static_cast<double>(m[0]) * rgb[0] + static_cast<double>(m[1]) * rgb[1] +
                     static_cast<double>(m[2]) * rgb[2] + static_cast<double>(m[3]));
  }
  return out;
}

TEST_P(ColorGrid, MatchesTheLoopAndTheIdentityChangesNothing) {
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  // Larger than its cells, and (second case) with more vertices than pixels.
  for (const auto& [width, height, x, y, z] : {std::array{50, 37, 4, 3, 5}, std::array{11, 7, 16, 16, 8}}) {
    const test::Shot shot = test::shot_of(test::kCameraStill, width, height);
    RenderOptions options = paper_options();
    options.precision = GetParam();
    Renderer renderer(device_, options);
    const SensorRays rays = shot.on(device_, options);
    test::SetRecipe recipe;
    recipe.count = 200;
    recipe.low = {3.0, -2.0, -1.5};
    recipe.high = {9.0, 2.0, 1.5};
    recipe.scale_min = 0.1;
    recipe.scale_max = 0.6;
    recipe.sh_spread = 3.0;
    const ParticleBuffers particles(device_, test::set_for(test::kCameraStill, recipe, 4), GetParam());
    Pass pass = renderer.render(particles, rays, shot.view);
    const RayResults plain = pass.results();
    const ColorGrids grids = random_grids(x, y, z);
    const ColorGridBuffers buffers(device_, grids, GetParam());
    pass.grade(buffers, 1);
    const RayResults found = pass.results();
    const double tolerance = GetParam() == Precision::kDouble ? 1e-6 : 1e-5;  // results are floats
    double beyond = 0.0;
    for (std::size_t i = 0; i < plain.rays; ++i) {
      const double rgb[3] = {plain.feature[0][i], plain.feature[1][i], plain.feature[2][i]};
      beyond = std::max(beyond, rgb[1]);
      for (std::size_t c = 0; c < 3; ++c) {
        const int column = static_cast<int>(i) % width, row = static_cast<int>(i) / width;
        ASSERT_NEAR(found.feature[c][i], graded(grids, 1, shot.camera, column, row, rgb, c), tolerance);
      }
      ASSERT_EQ(found.transmittance[i], plain.transmittance[i]);
    }
    EXPECT_GT(beyond, 1.0);  // includes luminances beyond the grid's end
    pass = renderer.render(particles, rays, shot.view);
    const ColorGridBuffers neutral(device_, ColorGrids::identity(x, y, z, {{"front", 0.0}}), GetParam());
    pass.grade(neutral, 0);
    for (std::size_t c = 0; c < 3; ++c) {
      const RayResults same = pass.results();
      for (std::size_t i = 0; i < plain.rays; ++i) {
        ASSERT_NEAR(same.feature[c][i], plain.feature[c][i], 1e-6 * (1.0 + std::abs(plain.feature[c][i])));
      }
    }
  }
}

/// Difference quotients are inaccurate in float.
class ColorGridInDouble : public ColorGrid {};

TEST_P(ColorGridInDouble, GradientsMatchQuotientsAndWrongOnesDoNot) {
  SIMULI_NEEDS_DOUBLE(device_);
  for (const auto& [width, height, x, y, z] : {std::array{50, 37, 4, 3, 5}, std::array{11, 7, 16, 16, 2}}) {
    shared::FrameParams frame{};
    frame.tiles_x = static_cast<std::uint32_t>((width + 15) / 16);
    frame.tiles_y = static_cast<std::uint32_t>((height + 15) / 16);
    frame.slots = frame.tiles_x * frame.tiles_y * SIM_TILE_RAYS;
    const std::size_t s = frame.slots;
    ColorGridBuffers grids(device_, random_grids(x, y, z), GetParam());
    ColorGridStage stage(device_, grids);
    Blended blended(device_, GetParam());
    GradientBuffers gradients(device_, GetParam());
    ColorGridBackwardStage back(device_, grids);
    RealBuffer picture(device_, "picture", GetParam());
    RealBuffer grads(device_, "grid gradients", GetParam());
    const auto is_pixel = [&](std::size_t slot) {
      const std::size_t tile = slot / 256, block = slot % 256 / 16, inside = slot % 16;
      return static_cast<int>(tile % frame.tiles_x * 16 + block % 4 * 4 + inside % 4) < width &&
             static_cast<int>(tile / frame.tiles_x * 16 + block / 4 * 4 + inside / 4) < height;
    };
    test::Random random(19);
    std::vector<double> out(6 * s), weights(5 * s, 0.0);
    for (double& value : out) value = random.uniform(-0.2, 1.2);  // luminances beyond both ends as well
    for (std::size_t i = 0; i < 3 * s; ++i) weights[i] = is_pixel(i % s) ? random.normal() : 0.0;
    std::vector<double> values = grids.grid.download_double();
    constexpr ColorGridScale kScale{0.3, 0.9};
    const std::size_t reals = grids.reals();
    const auto vertex = [&](int i, int j, int k, std::size_t n) {
      return values[reals + static_cast<std::size_t>(((j * x + i) * z + k) * 16) + n];
    };
    const auto loss = [&] {
      blended.out.assign(std::span<const double>(out));
      grids.grid.assign(std::span<const double>(values));
      stage.run(frame, width, height, grids, 1, blended, picture);
      const std::vector<double> found = picture.download_double();
      double sum = 0.0;
      for (std::size_t i = 0; i < found.size(); ++i) sum += weights[i] * found[i];
      for (int j = 0; j < y; ++j) {
        for (int i = 0; i < x; ++i) {
          for (int k = 0; k < z; ++k) {
            for (std::size_t n = 0; n < 12; ++n) {
              const double here = vertex(i, j, k, n);
              const double identity = n % 5 == 0 ? 1.0 : 0.0;
              sum += kScale.drift * std::pow(here - identity, 2);
              if (i + 1 < x) sum += kScale.variation * std::pow(here - vertex(i + 1, j, k, n), 2);
              if (j + 1 < y) sum += kScale.variation * std::pow(here - vertex(i, j + 1, k, n), 2);
              if (k + 1 < z) sum += kScale.variation * std::pow(here - vertex(i, j, k + 1, n), 2);
            }
          }
        }
      }
      return sum;
    };
    (void)loss();
    gradients.grad_out.assign(std::span<const double>(weights));
    back.run(frame, width, height, grids, 1, kScale, blended, gradients, grads);
    const std::vector<double> of_grid = grads.download_double();
    std::vector<double> of_colour = gradients.grad_out.download_double();

    std::vector<std::size_t> entries;
    for (std::size_t i = 0; i < reals; i += 7) {
      if (i % 16 < 12) {
        entries.push_back(i);
      } else {
        EXPECT_EQ(of_grid[i], 0.0);
      }
    }
    const test::Quotients grid = test::compare_quotients(of_grid, entries, [&](std::size_t i, double by) {
      const double before = values[reals + i];
      values[reals + i] = before + by;
      const double result = loss();
      values[reals + i] = before;
      return result;
    });
    EXPECT_LE(grid.error, kGradientTolerance);
    EXPECT_GT(grid.error_if_scaled, kGradientTolerance);

    entries.clear();
    for (std::size_t i = 0; i < 3 * s; i += 37) {
      // Quotients across a kink are invalid: luminances at a vertex or at the ends of the grid.
      const std::size_t slot = i % s;
      const double luminance = 0.299 * out[slot] + 0.587 * out[s + slot] + 0.114 * out[2 * s + slot];
      const double place = luminance * (z - 1);
      if (is_pixel(slot) && std::abs(place - std::round(place)) > 1e-3) entries.push_back(i);
    }
    const test::Quotients colour = test::compare_quotients(of_colour, entries, [&](std::size_t i, double by) {
      const double before = out[i];
      out[i] = before + by;
      const double result = loss();
      out[i] = before;
      return result;
    });
    EXPECT_LE(colour.error, kGradientTolerance);
    EXPECT_GT(colour.error_if_scaled, kGradientTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ColorGridInDouble, testing::Values(Precision::kDouble));
INSTANTIATE_TEST_SUITE_P(All,
                         ColorGrid,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli
