#include "optim/init/initialize_environment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/core/base/spread.hpp"

namespace simuli {
namespace {

/// Sums of colours over a grid of texels.
class Level {
 public:
  int width = 0;
  int height = 0;
  std::vector<Eigen::Vector4f> sum;  // [height][width] colours and their count

  Level(int w, int h)
      : width(w),
        height(h),
        sum(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), Eigen::Vector4f::Zero()) {}
  [[nodiscard]] Eigen::Vector4f& at(int x, int y) { return sum[index(x, y)]; }
  [[nodiscard]] const Eigen::Vector4f& at(int x, int y) const { return sum[index(x, y)]; }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

Level halved(Level& fine) {
  Level coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) coarse.at(x / 2, y / 2) += fine.at(x, y);
  }
  return coarse;
}

/// Fills cells without colour with the mean of their row, and rows without colour with the nearest row that has
/// one: sky continues upwards and around, ground downwards.
void inpaint_by_rows(Level& level) {
  std::vector<Eigen::Vector4f> means;
  for (int y = 0; y < level.height; ++y) {
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (int x = 0; x < level.width; ++x) {
      const Eigen::Vector4f& cell = level.at(x, y);
      if (cell.w() > 0.0F) sum += cell / cell.w();
    }
    means.push_back(sum);
  }
  for (int y = 0; y < level.height; ++y) {
    // Prefers the row above when two are equally near.
    int nearest = y;
    for (int away = 1; means[static_cast<std::size_t>(nearest)].w() == 0.0F && away < level.height; ++away) {
      if (y - away >= 0 && means[static_cast<std::size_t>(y - away)].w() > 0.0F)
        nearest = y - away;
      else if (y + away < level.height && means[static_cast<std::size_t>(y + away)].w() > 0.0F)
        nearest = y + away;
    }
    for (int x = 0; x < level.width; ++x) {
      if (level.at(x, y).w() == 0.0F) level.at(x, y) = means[static_cast<std::size_t>(nearest)];
    }
  }
}

}  // namespace

std::array<float, 3> sky_colour(const std::vector<FarShell::Patch>& patches) {
  std::vector<float> heights;
  for (const FarShell::Patch& patch : patches) heights.push_back(patch.direction.z());
  const float middle = upper_median(std::move(heights));
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0.0F;
  for (const FarShell::Patch& patch : patches) {
    if (patch.direction.z() < middle) continue;
    sum += patch.colour;
    count += 1.0F;
  }
  return {sum.x() / count, sum.y() / count, sum.z() / count};
}

EnvironmentMap environment_of(const std::vector<FarShell::Patch>& patches, int width) {
  constexpr float kPi = std::numbers::pi_v<float>;
  const int height = width / 2;
  std::vector<Level> levels{Level(width, height)};
  for (const FarShell::Patch& patch : patches) {
    const Eigen::Vector3f& d = patch.direction;
    const float x = (0.5F - std::atan2(d.y(), d.x()) / (2.0F * kPi)) * static_cast<float>(width);
    const float y = (0.5F - std::asin(std::clamp(d.z(), -1.0F, 1.0F)) / kPi) * static_cast<float>(height);
    Eigen::Vector4f& texel = levels[0].at(std::clamp(static_cast<int>(x), 0, width - 1),
                                          std::clamp(static_cast<int>(y), 0, height - 1));
    texel += Eigen::Vector4f(patch.colour.x(), patch.colour.y(), patch.colour.z(), 1.0F);
  }
  // Small holes of a fine map are filled with the mean of the surrounding block.
  constexpr int kCoarse = 64;  // largest number of cells around
  while (levels.back().width > kCoarse) levels.push_back(halved(levels.back()));
  inpaint_by_rows(levels.back());

  EnvironmentMap map{width, height, {}};
  map.texels.reserve(3 * levels[0].sum.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Eigen::Vector4f texel(0.5F, 0.5F, 0.5F, 1.0F);  // default without patches
      for (std::size_t k = 0; k < levels.size(); ++k) {
        const Eigen::Vector4f& sum = levels[k].at(x >> k, y >> k);
        if (sum.w() == 0.0F) continue;
        texel = sum / sum.w();
        break;
      }
      for (int c = 0; c < 3; ++c) map.texels.push_back(texel[c]);
    }
  }
  return map;
}

}  // namespace simuli
