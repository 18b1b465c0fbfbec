#include "optim/init/sky.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

constexpr int kReach_px = 2;  // half side of the square for texture
constexpr float kFlat = 0.02F;  // largest standard deviation of grey values in it
constexpr float kLeastShare = 0.35F;  // relative to the 99th percentile of grey values
constexpr float kAlike = 0.03F;  // largest difference of a channel between two areas of one sky
constexpr float kSame = 0.04F;  // between a sky pixel and its neighbour
constexpr std::size_t kLeastArea = 20;  // px
// Largest numbers of returns in a sky area, from occluders seen with the parallax between LiDAR and camera.
constexpr double kReturns = 5.0, kReturnsPerPixel = 0.002;
constexpr double kApart_s = 0.5;  // largest time between picture and sweep

/// Mean over the square of kReach_px around each pixel, with extended borders.
std::vector<float> box_mean(const std::vector<float>& values, int width, int height) {
  std::vector<float> rows(values.size()), out(values.size());
  const auto at = [width](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  constexpr float kShare = 1.0F / (2 * kReach_px + 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float sum = 0.0F;
      for (int d = -kReach_px; d <= kReach_px; ++d) sum += values[at(std::clamp(x + d, 0, width - 1), y)];
      rows[at(x, y)] = kShare * sum;
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float sum = 0.0F;
      for (int d = -kReach_px; d <= kReach_px; ++d) sum += rows[at(x, std::clamp(y + d, 0, height - 1))];
      out[at(x, y)] = kShare * sum;
    }
  }
  return out;
}

/// Bright pixels without texture above the horizon.
std::vector<bool> candidates(const ImageView& view, const Image& image) {
  const std::size_t pixels = image.data.size() / 3;
  std::vector<float> grey(pixels), squared(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    grey[i] = (image.data[3 * i] + image.data[3 * i + 1] + image.data[3 * i + 2]) / 3.0F;
    squared[i] = grey[i] * grey[i];
  }
  std::vector<float> sorted = grey;
  const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(99 * pixels / 100);
  std::nth_element(sorted.begin(), bright, sorted.end());
  const float least = kLeastShare * *bright;
  const std::vector<float> mean = box_mean(grey, image.width, image.height);
  const std::vector<float> mean_squared = box_mean(squared, image.width, image.height);
  std::vector<bool> out(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool is_flat = mean_squared[i] - mean[i] * mean[i] < kFlat * kFlat;
    if (!is_flat || !(grey[i] > least) || !(image.data[3 * i] >= 0.0F)) continue;
    const auto width = static_cast<std::size_t>(image.width);
    Eigen::Vector3d origin, direction;
    view.unproject(
        {static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5}, origin, direction);
    out[i] = direction.z() > 0.0;
  }
  return out;
}

struct Area {
  std::size_t pixels = 0, returns = 0;
  bool touches_border = false;
  Eigen::AlignedBox3f colours;

  [[nodiscard]] bool is_open() const {
    return pixels >= kLeastArea &&
           static_cast<double>(returns) <= kReturns + kReturnsPerPixel * static_cast<double>(pixels);
  }
  [[nodiscard]] bool is_like(const Area& other) const {
    const Eigen::Array3f gap =
        (colours.min() - other.colours.max()).array().max((other.colours.min() - colours.max()).array());
    return gap.maxCoeff() <= kAlike;
  }
};

/// Numbers connected candidate areas from 1 on; 0: none.
std::vector<std::uint32_t> areas_of(const std::vector<bool>& candidate,
                                    const Image& image,
                                    std::vector<Area>& areas) {
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  std::vector<std::uint32_t> number(candidate.size());
  std::vector<std::size_t> open;
  for (std::size_t seed = 0; seed < candidate.size(); ++seed) {
    if (!candidate[seed] || number[seed] != 0) continue;
    areas.emplace_back();
    const auto here = static_cast<std::uint32_t>(areas.size());
    number[seed] = here;
    open.push_back(seed);
    Area& area = areas.back();
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      ++area.pixels;
      area.colours.extend(Eigen::Vector3f::Map(&image.data[3 * i]));
      const std::size_t x = i % width, y = i / width;
      const auto visit = [&](bool inside, std::size_t next) {
        if (!inside) {
          area.touches_border = true;
        } else if (candidate[next] && number[next] == 0) {
          number[next] = here;
          open.push_back(next);
        }
      };
      visit(x > 0, i - 1);
      visit(x + 1 < width, i + 1);
      visit(y > 0, i - width);
      visit(y + 1 < height, i + width);
    }
  }
  return number;
}

/// Selects the largest open area that touches the border, and areas similar to it or to a selected one that
/// touches it: wires divide a sky of varying colour.
std::vector<bool> sky_of(const std::vector<Area>& areas) {
  std::vector<bool> is_sky(areas.size());
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < areas.size(); ++k) {
    const bool is_larger = found.empty() || areas[k].pixels > areas[found[0]].pixels;
    if (areas[k].touches_border && areas[k].is_open() && is_larger) found = {k};
  }
  for (std::size_t at = 0; at < found.size(); ++at) {
    const Area& area = areas[found[at]];
    is_sky[found[at]] = true;
    for (std::size_t k = 0; k < areas.size() && area.touches_border; ++k) {
      if (is_sky[k] || !areas[k].is_open() || !areas[k].is_like(area)) continue;
      is_sky[k] = true;
      found.push_back(k);
    }
  }
  return is_sky;
}

/// Adds neighbours of the sky's brightness: squares across its edge are textured.
void grow(std::vector<bool>& sky, const Image& image) {
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  std::vector<std::pair<std::size_t, std::size_t>> edge, next;  // pixel, and the sky pixel that it is compared with
  for (std::size_t i = 0; i < sky.size(); ++i) {
    if (sky[i]) edge.emplace_back(i, i);
  }
  for (int step = 0; step <= kReach_px; ++step) {
    for (const auto& [i, from] : edge) {
      const auto take = [&, from = from](bool inside, std::size_t to) {
        if (!inside || sky[to]) return;
        for (std::size_t c = 0; c < 3; ++c) {
          if (std::abs(image.data[3 * to + c] - image.data[3 * from + c]) > kSame) return;
        }
        sky[to] = true;
        next.emplace_back(to, from);
      };
      take(i % width > 0, i - 1);
      take(i % width + 1 < width, i + 1);
      take(i / width > 0, i - width);
      take(i / width + 1 < height, i + width);
    }
    edge = std::move(next);
    next.clear();
  }
}

}  // namespace

SkyMask::SkyMask(int width, int height, std::vector<bool> sky)
    : width_(width), height_(height), sky_(std::move(sky)) {}

SkyMask find_sky(const ImageView& view, const Image& image, const std::vector<Eigen::Matrix3Xd>& returns) {
  if (returns.empty()) return {};
  std::vector<Area> areas;
  const std::vector<std::uint32_t> number = areas_of(candidates(view, image), image, areas);
  const ViewCone cone(view);
  for (const Eigen::Matrix3Xd& points : returns) {
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      Eigen::Vector2d pixel;
      double range_m = 0.0;
      if (!cone.may_meet(points.col(i), 0.0) || !view.project(points.col(i), pixel, range_m)) continue;
      const auto x = static_cast<std::size_t>(pixel.x()), y = static_cast<std::size_t>(pixel.y());
      const std::uint32_t area = number[y * static_cast<std::size_t>(image.width) + x];
      if (area != 0) ++areas[area - 1].returns;
    }
  }
  const std::vector<bool> is_sky = sky_of(areas);
  std::vector<bool> sky(number.size());
  for (std::size_t i = 0; i < sky.size(); ++i) sky[i] = number[i] != 0 && is_sky[number[i] - 1];
  grow(sky, image);
  return {image.width, image.height, std::move(sky)};
}

bool SkyMask::at(const Eigen::Vector2d& pixel) const {
  if (sky_.empty()) return false;
  const int x = std::clamp(static_cast<int>(pixel.x()), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(pixel.y()), 0, height_ - 1);
  return sky_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
}

SkyFinder::SkyFinder(const Log& log, std::vector<const SweepFrame*> sweeps, const Eigen::Vector3d& origin)
    : log_(log), sweeps_(std::move(sweeps)), origin_(origin) {}

SkyMask SkyFinder::find(const ImageFrame& frame, const Image& image, const ImageView& view) {
  Sweeps nearest;
  const auto apart_s = [&](const SweepFrame& sweep) {
    return std::abs(0.5 * (sweep.time_start_s + sweep.time_end_s) - middle_s(frame));
  };
  for (const SweepFrame* sweep : sweeps_) {
    const SweepFrame*& best = nearest[sweep->lidar];
    if (apart_s(*sweep) <= kApart_s && (best == nullptr || apart_s(*sweep) < apart_s(*best))) best = sweep;
  }
  if (nearest != read_) {
    returns_.clear();
    read_ = {};  // unless all can be read
    for (const auto& [name, sweep] : nearest) {
      if (sweep != nullptr) returns_.push_back(read(*sweep));
    }
    read_ = nearest;
  }
  return find_sky(view, image, returns_);
}

Eigen::Matrix3Xd SkyFinder::read(const SweepFrame& sweep) const {
  const PosedSweep posed = load_sweep(log_, sweep, origin_);
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(posed.sweep.range.size()));
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < posed.sweep.range.size(); ++i) {
    if (!(posed.sweep.range[i] > 0.0F)) continue;
    const SceneRay ray = ray_in_scene(posed, i);
    points.col(count++) = ray.origin + static_cast<double>(posed.sweep.range[i]) * ray.direction;
  }
  return points.leftCols(count);
}

}  // namespace simuli
