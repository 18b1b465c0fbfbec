#include "optim/init/plane_sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "host/core/base/parallel.hpp"

namespace simuli {
namespace {

constexpr int kPatchReach = 2;       // px of the half-size picture: patches of 5 x 5
constexpr int kDistances = 128;      // steps of inverse distance
constexpr int kLattice_px = 4;       // spacing of projected rays, between which positions are interpolated
constexpr float kWorstCost = 0.10F;  // mean grey difference above which nothing matches
constexpr float kMostCost = 2.0F * kWorstCost;
constexpr float kSameCost = 0.001F;     // smaller differences are ties: the farther distance wins
constexpr float kSameShare = 0.2F;      // relative to the best cost: noise level
constexpr std::size_t kLeastViews = 2;  // that must agree
// Smoothness costs of SGM for neighbours that differ by one step of distance, and by more (docs/DECISIONS.md,
// "Initialisation").
constexpr float kStepCost = 0.01F, kJumpCost = 0.05F;
constexpr double kLikeSteps = 2.0;  // largest difference of distances that confirm each other
constexpr double kSureShare = 0.3;  // share of confirming neighbours
// Side of pixel blocks, each of which gives one point (docs/DECISIONS.md, "Initialisation").
constexpr int kBlock_px = 2;

/// Step 0 is beyond kSweepFarthest_m; fractional steps are in between.
double distance_of(double step) {
  if (step < 1.0) return 10.0 * kSweepFarthest_m;
  const double far = 1.0 / kSweepFarthest_m, near = 1.0 / kSweepNearest_m;
  return 1.0 / (far + (near - far) * (step - 1.0) / (kDistances - 2));
}

/// Pixels whose distance is computed.
struct Requested {
  static constexpr std::uint32_t kNot = std::numeric_limits<std::uint32_t>::max();
  int width, height;
  std::vector<std::uint32_t> number;     // [height][width] index of a requested pixel, or kNot
  std::vector<Eigen::Vector2i> at = {};  // their positions

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

Requested requested_of(const SweepPicture& picture, const Coverage& coverage) {
  Requested out{picture.grey.width, picture.grey.height, {}};
  out.number.assign(picture.grey.data.size(), Requested::kNot);
  const double scale_x = static_cast<double>(picture.full_width) / out.width;
  const double scale_y = static_cast<double>(picture.full_height) / out.height;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const Eigen::Vector2d full{(x + 0.5) * scale_x, (y + 0.5) * scale_y};
      if (!coverage.is_empty_around(static_cast<int>(full.x()) / coverage.cell_px,
                                    static_cast<int>(full.y()) / coverage.cell_px) ||
          picture.sky.at(full) || picture.view.hides({x + 0.5, y + 0.5})) {
        continue;
      }
      out.number[out.index(x, y)] = static_cast<std::uint32_t>(out.at.size());
      out.at.emplace_back(x, y);
    }
  }
  return out;
}

/// Pixel values of a picture, with a border of zeros of the patch radius.
class Padded {
 public:
  Padded(int width, int height)
      : stride_(static_cast<std::size_t>(width + 2 * kPatchReach)),
        values_(stride_ * static_cast<std::size_t>(height + 2 * kPatchReach)),
        rows_(values_.size()) {}
  void clear() { std::fill(values_.begin(), values_.end(), 0.0F); }
  [[nodiscard]] float& at(int x, int y) {
    return values_[static_cast<std::size_t>(y + kPatchReach) * stride_ +
                   static_cast<std::size_t>(x + kPatchReach)];
  }
  /// Replaces each value by the sum over its patch.
  void sum_patches() {
    for (std::size_t i = kPatchReach; i + kPatchReach < values_.size(); ++i) {
      rows_[i] = values_[i - 2] + values_[i - 1] + values_[i] + values_[i + 1] + values_[i + 2];
    }
    for (std::size_t i = kPatchReach * stride_; i + kPatchReach * stride_ < values_.size(); ++i) {
      values_[i] = rows_[i - 2 * stride_] + rows_[i - stride_] + rows_[i] + rows_[i + stride_] +
                   rows_[i + 2 * stride_];
    }
  }

 private:
  static_assert(kPatchReach == 2);
  std::size_t stride_;
  std::vector<float> values_;
  std::vector<float> rows_;  // horizontal sums
};

/// Matching costs of a picture's patches against other pictures at each distance.
class Matching {
 public:
  Matching(const SweepPicture& picture,
           const std::vector<const SweepPicture*>& others,
           const Requested& requested)
      : picture_(picture),
        others_(others),
        requested_(requested),
        columns_((requested.width + kLattice_px - 1) / kLattice_px + 1),
        rows_((requested.height + kLattice_px - 1) / kLattice_px + 1),
        nodes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    for (int row = 0; row + 1 < rows_; ++row) {
      for (int column = 0; column + 1 < columns_; ++column) {
        if (is_requested_for(column, row)) add_cell(column, row);
      }
    }
  }

  /// Returns [requested][kDistances] costs: the mean of the better half of the pictures, because others may be
  /// occluded; twice the worst cost where it is larger, or fewer than kLeastViews show the patch.
  [[nodiscard]] std::vector<float> costs() const {
    std::vector<float> out(requested_.at.size() * kDistances);
    constexpr std::size_t kEach = 1;
    parallel_ranges(
        kDistances,
        [&](std::size_t begin, std::size_t end) {
          Scratch scratch(requested_, nodes_.size(), others_.size());
          for (std::size_t step = begin; step < end; ++step) match(step, scratch, out);
        },
        kEach);
    return out;
  }

 private:
  struct Ray {
    Eigen::Vector3d origin, direction = Eigen::Vector3d::Zero();  // zero without a ray
  };
  /// Pixels between four lattice nodes.
  struct Cell {
    int left, top;                     // px
    std::array<std::size_t, 4> nodes;  // upper left and right, lower left and right
  };
  struct Scratch {
    Scratch(const Requested& requested, std::size_t nodes, std::size_t others)
        : difference(requested.width, requested.height),
          shown(requested.width, requested.height),
          places(nodes),
          is_shown(requested.at.size()),
          costs(requested.at.size() * others),
          seen(requested.at.size()) {}
    Padded difference, shown;                            // of another picture
    std::vector<std::optional<Eigen::Vector2f>> places;  // [nodes] positions in it
    std::vector<std::uint8_t> is_shown;                  // [requested]
    std::vector<float> costs;                            // [requested][others], smallest first
    std::vector<std::size_t> seen;                       // [requested], number of pictures that show it
  };

  [[nodiscard]] Ray ray_of(int x, int y) const {
    Ray ray;
    picture_.view.unproject({x + 0.5, y + 0.5}, ray.origin, ray.direction);
    return ray;
  }
  /// Whether the patch of a requested pixel extends into a cell.
  [[nodiscard]] bool is_requested_for(int column, int row) const {
    const int left = column * kLattice_px, top = row * kLattice_px;
    const int right = std::min(left + kLattice_px + kPatchReach, requested_.width);
    const int bottom = std::min(top + kLattice_px + kPatchReach, requested_.height);
    for (int y = std::max(top - kPatchReach, 0); y < bottom; ++y) {
      for (int x = std::max(left - kPatchReach, 0); x < right; ++x) {
        if (requested_.number[requested_.index(x, y)] != Requested::kNot) return true;
      }
    }
    return false;
  }
  void add_cell(int column, int row) {
    const auto node = [&](int right, int below) {
      const auto i = static_cast<std::size_t>(row + below) * static_cast<std::size_t>(columns_) +
                     static_cast<std::size_t>(column + right);
      nodes_[i] = ray_of((column + right) * kLattice_px, (row + below) * kLattice_px);
      return i;
    };
    cells_.push_back(
        {column * kLattice_px, row * kLattice_px, {node(0, 0), node(1, 0), node(0, 1), node(1, 1)}});
  }
  [[nodiscard]] static std::optional<Eigen::Vector2f> place_in(const SweepPicture& other,
                                                               const Ray& ray,
                                                               double distance_m) {
    Eigen::Vector2d pixel;
    double range_m = 0.0;
    if (ray.direction.isZero() ||
        !other.view.project(ray.origin + distance_m * ray.direction, pixel, range_m)) {
      return std::nullopt;
    }
    return pixel.cast<float>();
  }

  void match(std::size_t step, Scratch& scratch, std::vector<float>& out) const {
    std::fill(scratch.seen.begin(), scratch.seen.end(), 0);
    const double distance_m = distance_of(static_cast<double>(step));
    for (const SweepPicture* other : others_) compare(*other, distance_m, scratch);
    for (std::size_t i = 0; i < requested_.at.size(); ++i) {
      float& cost = out[i * kDistances + step] = kMostCost;
      const std::size_t seen = scratch.seen[i], used = std::max(kLeastViews, (seen + 1) / 2);
      if (seen < kLeastViews) continue;
      const float* const least = &scratch.costs[i * others_.size()];
      float sum = 0.0F;
      for (std::size_t k = 0; k < used; ++k) sum += least[k];
      cost = std::min(cost, sum / static_cast<float>(used));
    }
  }

  /// Adds the costs of another picture.
  void compare(const SweepPicture& other, double distance_m, Scratch& scratch) const {
    scratch.difference.clear();
    scratch.shown.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      scratch.places[i] = place_in(other, nodes_[i], distance_m);
    }
    for (const Cell& cell : cells_) compare_cell(other, distance_m, cell, scratch);
    for (std::size_t i = 0; i < requested_.at.size(); ++i) {
      scratch.is_shown[i] = scratch.shown.at(requested_.at[i].x(), requested_.at[i].y()) > 0.0F ? 1 : 0;
    }
    scratch.difference.sum_patches();
    scratch.shown.sum_patches();
    for (std::size_t i = 0; i < requested_.at.size(); ++i) {
      if (scratch.is_shown[i] == 0) continue;
      const int x = requested_.at[i].x(), y = requested_.at[i].y();
      const float cost = scratch.difference.at(x, y) / scratch.shown.at(x, y);
      float* const costs = &scratch.costs[i * others_.size()];
      std::size_t k = scratch.seen[i]++;
      for (; k > 0 && costs[k - 1] > cost; --k) costs[k] = costs[k - 1];
      costs[k] = cost;
    }
  }

  void compare_cell(const SweepPicture& other, double distance_m, const Cell& cell, Scratch& scratch) const {
    const auto& [a, b, c, d] = cell.nodes;
    const std::vector<std::optional<Eigen::Vector2f>>& at = scratch.places;
    if (!at[a] && !at[b] && !at[c] && !at[d]) return;
    const bool all = at[a] && at[b] && at[c] && at[d];
    const auto between = [&](float u, float v) -> Eigen::Vector2f {
      return (1.0F - v) * ((1.0F - u) * *at[a] + u * *at[b]) + v * ((1.0F - u) * *at[c] + u * *at[d]);
    };
    for (int y = cell.top; y < std::min(cell.top + kLattice_px, requested_.height); ++y) {
      for (int x = cell.left; x < std::min(cell.left + kLattice_px, requested_.width); ++x) {
        const std::optional<Eigen::Vector2f> place =
            all ? between(static_cast<float>(x - cell.left) / kLattice_px,
                          static_cast<float>(y - cell.top) / kLattice_px)
                : place_in(other, ray_of(x, y), distance_m);
        if (!place) continue;
        scratch.difference.at(x, y) =
            std::abs(picture_.grey.at(x, y, 0) - sample_bilinear<1>(other.grey, *place)(0));
        scratch.shown.at(x, y) = 1.0F;
      }
    }
  }

  const SweepPicture& picture_;
  const std::vector<const SweepPicture*>& others_;
  const Requested& requested_;
  int columns_, rows_;       // of the lattice
  std::vector<Ray> nodes_;   // [rows][columns]; empty without requested pixels
  std::vector<Cell> cells_;  // between four nodes with rays
};

/// Path costs along a row of pixels in one direction.
struct Paths {
  explicit Paths(int width)
      : costs(static_cast<std::size_t>(width) * kDistances), least(static_cast<std::size_t>(width), kNone) {}
  static constexpr float kNone = -1.0F;
  std::vector<float> costs;  // [width][kDistances]
  std::vector<float> least;  // [width], smallest of a pixel, or kNone
};

/// Advances path costs by one pixel: `path` from the previous pixel's. Returns the smallest.
float go_on(const float* cost, const float* before, float least, float* path) {
  const auto cheapest = [&](int step, float beside) {
    return cost[step] + std::min({before[step], beside + kStepCost, least + kJumpCost}) - least;
  };
  path[0] = cheapest(0, before[1]);
  for (int step = 1; step + 1 < kDistances; ++step) {
    path[step] = cheapest(step, std::min(before[step - 1], before[step + 1]));
  }
  path[kDistances - 1] = cheapest(kDistances - 1, before[kDistances - 2]);
  return *std::min_element(path, path + kDistances);
}

/// Adds the cheapest path costs along (dx, dy) to each pixel (Hirschmüller 2008, equation 13).
void add_paths(
    const Requested& requested, const std::vector<float>& costs, int dx, int dy, std::vector<float>& sums) {
  const bool is_forward = dy > 0 || (dy == 0 && dx > 0);
  Paths last(requested.width), here(requested.width);
  for (int row = 0; row < requested.height; ++row) {
    const int y = is_forward ? row : requested.height - 1 - row;
    std::swap(last, here);
    std::fill(here.least.begin(), here.least.end(), Paths::kNone);
    const Paths& before = dy == 0 ? here : last;
    for (int column = 0; column < requested.width; ++column) {
      const int x = is_forward ? column : requested.width - 1 - column, from = x - dx;
      const std::uint32_t number = requested.number[requested.index(x, y)];
      if (number == Requested::kNot) continue;
      const auto place = [](std::size_t i) { return i * kDistances; };
      const float* const cost = &costs[place(number)];
      float* const path = &here.costs[place(static_cast<std::size_t>(x))];
      float& least = here.least[static_cast<std::size_t>(x)];
      const bool goes_on =
          from >= 0 && from < requested.width && before.least[static_cast<std::size_t>(from)] != Paths::kNone;
      if (goes_on) {
        const auto i = static_cast<std::size_t>(from);
        least = go_on(cost, &before.costs[place(i)], before.least[i], path);
      } else {
        std::copy_n(cost, kDistances, path);
        least = *std::min_element(path, path + kDistances);
      }
      float* const sum = &sums[place(number)];
      for (int step = 0; step < kDistances; ++step) sum[step] += path[step];
    }
  }
}

/// Returns the means over paths from eight directions.
std::vector<float> with_neighbours(const Requested& requested, const std::vector<float>& costs) {
  constexpr std::array<std::array<int, 2>, 4> kSides{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  std::array<std::vector<float>, 2> sums;  // of paths in both directions
  constexpr std::size_t kEach = 1;
  parallel_each(
      sums.size(),
      [&](std::size_t k) {
        sums[k].resize(costs.size());
        const int sign = k == 0 ? 1 : -1;
        for (const auto& [dx, dy] : kSides) add_paths(requested, costs, sign * dx, sign * dy, sums[k]);
      },
      kEach);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    sums[0][i] = (sums[0][i] + sums[1][i]) / (2.0F * kSides.size());
  }
  return std::move(sums[0]);
}

/// A pixel's step of distance.
struct Step {
  double at = 0.0;       // fractional step from interpolated costs; 0: none
  bool is_sure = false;  // its own cost is distinctive at most distances
};

/// The median cost over the distances at which other pictures show the pixel.
float usual_cost(const float* own) {
  std::array<float, kDistances> some{};
  const auto end =
      std::copy_if(own, own + kDistances, some.begin(), [](float cost) { return cost < kMostCost; });
  const auto middle = some.begin() + (end - some.begin()) / 2;
  std::nth_element(some.begin(), middle, end);
  return *middle;
}

/// `own`, `costs`: [kDistances], without and with smoothing.
Step step_of(const float* own, const float* costs) {
  const auto alike = [](float best, float cost) { return cost <= (1.0F + kSameShare) * best + kSameCost; };
  const float best = *std::min_element(costs, costs + kDistances);
  const auto step =
      std::find_if(costs, costs + kDistances, [&](float cost) { return alike(best, cost); }) - costs;
  if (step == 0 || !(own[step] <= kWorstCost)) return {};
  Step out{static_cast<double>(step), !alike(own[step], usual_cost(own))};
  if (step < 2 || step + 1 == kDistances) return out;
  // The minimum of the parabola through three costs.
  const double slope = static_cast<double>(costs[step - 1]) - static_cast<double>(costs[step + 1]);
  const double bend = static_cast<double>(costs[step - 1]) - 2.0 * static_cast<double>(costs[step]) +
                      static_cast<double>(costs[step + 1]);
  const double off = bend > 0.0 ? slope / bend : slope;
  out.at += 0.5 * std::clamp(off, -1.0, 1.0);
  return out;
}

/// Whether enough neighbours have a similar distance with certainty.
bool is_confirmed(const Requested& requested, const std::vector<Step>& steps, std::size_t i) {
  const int x = requested.at[i].x(), y = requested.at[i].y();
  int all = 0, sure = 0;
  for (int v = std::max(y - kPatchReach, 0); v <= std::min(y + kPatchReach, requested.height - 1); ++v) {
    for (int u = std::max(x - kPatchReach, 0); u <= std::min(x + kPatchReach, requested.width - 1); ++u) {
      const std::uint32_t number = requested.number[requested.index(u, v)];
      if (number == Requested::kNot) continue;
      ++all;
      sure += steps[number].is_sure && std::abs(steps[number].at - steps[i].at) <= kLikeSteps ? 1 : 0;
    }
  }
  return sure >= kSureShare * all;
}

/// Returns for each block with confirmed pixels the one with the best match. `own`: [requested][kDistances]
std::vector<std::uint32_t> best_of_blocks(const Requested& requested,
                                          const std::vector<float>& own,
                                          const std::vector<Step>& steps) {
  const auto cost = [&](std::uint32_t i) {
    return own[i * std::size_t{kDistances} + static_cast<std::size_t>(std::lround(steps[i].at))];
  };
  std::map<std::array<int, 2>, std::uint32_t> best;
  for (std::uint32_t i = 0; i < steps.size(); ++i) {
    if (steps[i].at == 0.0 || !is_confirmed(requested, steps, i)) continue;
    const auto [block, is_first] =
        best.try_emplace({requested.at[i].y() / kBlock_px, requested.at[i].x() / kBlock_px}, i);
    if (!is_first && cost(i) < cost(block->second)) block->second = i;
  }
  std::vector<std::uint32_t> out;
  for (const auto& [block, i] : best) out.push_back(i);
  return out;
}

}  // namespace

SweepPicture sweep_picture(const ImageView& view, const Image& image, SkyMask sky) {
  const auto halved = [](int size) {
    return std::max(1, (size + SweepPicture::kPixel_px - 1) / SweepPicture::kPixel_px);
  };
  const Camera camera = view.camera().resized(halved(image.width), halved(image.height));
  const Image half = resize_area(image, camera.width, camera.height);
  SweepPicture out{view.with_camera(camera),
                   Image(camera.width, camera.height, 1),
                   image.width,
                   image.height,
                   std::move(sky)};
  for (std::size_t i = 0; i < out.grey.data.size(); ++i) {
    out.grey.data[i] = (half.data[3 * i] + half.data[3 * i + 1] + half.data[3 * i + 2]) / 3.0F;
  }
  return out;
}

std::vector<Eigen::Vector3d> sweep_depths(const SweepPicture& picture,
                                          const std::vector<const SweepPicture*>& others,
                                          const Coverage& coverage) {
  const Requested requested = requested_of(picture, coverage);
  std::vector<Eigen::Vector3d> points;
  if (requested.at.empty() || others.size() < kLeastViews) return points;
  const std::vector<float> own = Matching(picture, others, requested).costs();
  const std::vector<float> costs = with_neighbours(requested, own);
  std::vector<Step> steps(requested.at.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i] = step_of(&own[i * kDistances], &costs[i * kDistances]);
  }
  for (const std::uint32_t i : best_of_blocks(requested, own, steps)) {
    Eigen::Vector3d origin, direction;
    picture.view.unproject(
        requested.at[i].cast<double>() + Eigen::Vector2d::Constant(0.5), origin, direction);
    if (!direction.isZero()) points.emplace_back(origin + distance_of(steps[i].at) * direction);
  }
  return points;
}

}  // namespace simuli
