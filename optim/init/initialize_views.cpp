#include "optim/init/initialize_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/parallel.hpp"

namespace simuli {
namespace {

constexpr std::size_t kCellsPerThread = 1024;

}  // namespace

std::vector<SeenPoint> seen_points(const ImageView& view, const PointSet& points) {
  constexpr float kUnseen = -1.0F;
  std::vector<SeenPoint> all(points.size());
  parallel_each(points.size(), [&](std::size_t i) {
    const Eigen::Vector3d p_scene = points.position.col(static_cast<Eigen::Index>(i)).cast<double>();
    SeenPoint& seen = all[i];
    seen.index = static_cast<std::uint32_t>(i);
    if (!view.project(p_scene, seen.pixel, seen.range_m)) seen.range_m = kUnseen;
  });
  std::erase_if(all, [](const SeenPoint& seen) { return seen.range_m == kUnseen; });
  return all;
}

void Coverage::cover(const Eigen::Vector2d& pixel, double radius_px) {
  const double radius = std::min(radius_px, kMostRadius_px);
  const auto cell = [this](double at_px, int count) {
    return std::clamp(static_cast<int>(std::floor(at_px / cell_px)), 0, count - 1);
  };
  const int left = cell(pixel.x() - radius, columns), right = cell(pixel.x() + radius, columns);
  for (int row = cell(pixel.y() - radius, rows); row <= cell(pixel.y() + radius, rows); ++row) {
    const auto first = covered.begin() + static_cast<std::ptrdiff_t>(row) * columns;
    std::fill(first + left, first + right + 1, std::uint8_t{1});
  }
}

bool Coverage::is_empty_around(int column, int row) const {
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
      if (covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(x)] != 0) {
        return false;
      }
    }
  }
  return true;
}

ViewCone::ViewCone(const ImageView& view) {
  constexpr double kMargin_rad = 0.02, kMost_rad = 1.5;
  const Camera& camera = view.camera();
  view.unproject({0.5 * camera.width, 0.5 * camera.height}, origin_, axis_);
  if (axis_.isZero(0.0)) return;
  axis_.normalize();
  const auto add = [&](double x, double y) {
    Eigen::Vector3d origin, direction;
    view.unproject({x, y}, origin, direction);
    if (direction.isZero(0.0)) return false;
    const double cosine = std::clamp(direction.normalized().dot(axis_), -1.0, 1.0);
    half_rad_ = std::max(half_rad_, std::acos(cosine));
    moved_m_ = std::max(moved_m_, (origin - origin_).norm());
    return true;
  };
  for (int x = 0; x <= camera.width; ++x) {
    if (!add(x, 0.0) || !add(x, camera.height)) return;
  }
  for (int y = 0; y <= camera.height; ++y) {
    if (!add(0.0, y) || !add(camera.width, y)) return;
  }
  half_rad_ += kMargin_rad;
  bounded_ = half_rad_ < kMost_rad;
}

bool ViewCone::may_meet(const Eigen::Vector3d& centre, double radius_m) const {
  if (!bounded_) return true;
  const Eigen::Vector3d way = centre - origin_;
  const double away_m = way.norm(), reach_m = radius_m + moved_m_ + 1e-4 * away_m + 1e-3;
  if (!(away_m > reach_m)) return true;
  const double angle = std::acos(std::clamp(way.dot(axis_) / away_m, -1.0, 1.0));
  return !(angle - std::asin(reach_m / away_m) > half_rad_);
}

PointBlocks::PointBlocks(const PointSet& points) : order_(points.size()) {
  std::vector<std::array<int, 3>> cells(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i)) / kSide_m;
    const Eigen::Vector3i cell = p.array().floor().cast<int>();
    cells[i] = {cell.x(), cell.y(), cell.z()};
  }
  std::iota(order_.begin(), order_.end(), 0U);
  std::stable_sort(order_.begin(), order_.end(), [&cells](std::uint32_t a, std::uint32_t b) {
    return cells[a] < cells[b];
  });
  for (std::size_t first = 0, end = 0; first < order_.size(); first = end) {
    Eigen::AlignedBox3f box;
    for (end = first; end < order_.size() && cells[order_[end]] == cells[order_[first]]; ++end) {
      box.extend(points.position.col(order_[end]));
    }
    blocks_.push_back({box.center(), 0.5F * box.diagonal().norm(), first});
  }
}

template <class F>
std::vector<std::uint32_t> PointBlocks::points_of(F&& is_taken) const {
  constexpr double kSlack_m = 0.01;  // far above float rounding
  std::vector<std::uint8_t> taken(order_.size(), 0);
  std::size_t count = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    if (!is_taken(block.centre.cast<double>(), static_cast<double>(block.radius_m) + kSlack_m)) continue;
    const std::size_t end = i + 1 < blocks_.size() ? blocks_[i + 1].first : order_.size();
    for (std::size_t k = block.first; k < end; ++k) taken[order_[k]] = 1;
    count += end - block.first;
  }
  std::vector<std::uint32_t> out;
  out.reserve(count);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken[i] != 0) out.push_back(static_cast<std::uint32_t>(i));
  }
  return out;
}

std::vector<std::uint32_t> PointBlocks::seen_from(const ImageView& view, double farthest_m) const {
  const ViewCone cone(view);
  const Eigen::Vector3d eye = view.origin();
  return points_of([&](const Eigen::Vector3d& centre, double radius_m) {
    return (centre - eye).norm() - radius_m <= farthest_m && cone.may_meet(centre, radius_m);
  });
}

std::vector<std::uint32_t> PointBlocks::within(const Eigen::Vector3d& from, double farthest_m) const {
  return points_of([&](const Eigen::Vector3d& centre, double radius_m) {
    return (centre - from).norm() - radius_m <= farthest_m;
  });
}

NearestPoints::NearestPoints(const Camera& camera)
    : columns_((camera.width + kCell_px - 1) / kCell_px),
      rows_((camera.height + kCell_px - 1) / kCell_px),
      nearest_m_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                 std::numeric_limits<float>::infinity()) {}

std::size_t NearestPoints::cell_of(int x, int y) const {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
}

double NearestPoints::nearest_m(const Eigen::Vector2d& pixel) const {
  const int x = static_cast<int>(pixel.x()) / kCell_px, y = static_cast<int>(pixel.y()) / kCell_px;
  return static_cast<double>(nearest_m_[cell_of(x, y)]);
}

void NearestPoints::add(const Eigen::Vector2d& pixel, double range_m, double radius_px) {
  const int reach = static_cast<int>(std::min(radius_px, Coverage::kMostRadius_px) / kCell_px);
  const int x = static_cast<int>(pixel.x()) / kCell_px, y = static_cast<int>(pixel.y()) / kCell_px;
  for (int cy = std::max(y - reach, 0); cy <= std::min(y + reach, rows_ - 1); ++cy) {
    for (int cx = std::max(x - reach, 0); cx <= std::min(x + reach, columns_ - 1); ++cx) {
      float& nearest_m = nearest_m_[cell_of(cx, cy)];
      nearest_m = std::min(nearest_m, static_cast<float>(range_m));
    }
  }
}

Coverage look_at_points(const ImageView& view,
                        const Image& image,
                        const PointSet& points,
                        double point_size_m,
                        int cell_px,
                        std::vector<PointObservation>& observations) {
  const Camera& camera = view.camera();
  if (image.width != camera.width || image.height != camera.height || image.channels != 3 ||
      observations.size() != points.size() || cell_px < 1) {
    throw Error(ErrorKind::kInternal,
                "look_at_points: image, camera, points and observations do not fit together");
  }
  Coverage coverage;
  coverage.cell_px = cell_px;
  coverage.columns = (camera.width + cell_px - 1) / cell_px;
  coverage.rows = (camera.height + cell_px - 1) / cell_px;
  coverage.covered.assign(
      static_cast<std::size_t>(coverage.columns) * static_cast<std::size_t>(coverage.rows), 0);

  // First pass: nearest range per small cell, with each point's width in the picture ...
  NearestPoints nearest(camera);
  const std::vector<SeenPoint> seen = seen_points(view, points);
  for (const SeenPoint& s : seen) {
    const double radius_px = 0.5 * point_size_m / (view.pixel_size_at_1m() * s.range_m);
    coverage.cover(s.pixel, radius_px);
    nearest.add(s.pixel, s.range_m, radius_px);
  }
  // ... second pass: colours of points that no nearer point occludes.
  parallel_each(seen.size(), [&](std::size_t i) {
    const SeenPoint& s = seen[i];
    PointObservation& look = observations[s.index];
    if (nearest.hide(s.pixel, s.range_m)) return;
    const Eigen::Vector3f colour = sample_bilinear<3>(image, s.pixel);
    ++look.images;
    look.colours.extend(colour);
    const auto range_m = static_cast<float>(s.range_m);
    if (!(range_m < look.range_m)) return;
    look.range_m = range_m;
    look.footprint_m = static_cast<float>(s.range_m * view.pixel_size_at_1m());
    look.colour = colour;
  });
  return coverage;
}

std::size_t join_by_footprint(PointSet& points,
                              std::vector<PointObservation>& observations,
                              double finest_m,
                              double pixels) {
  struct Key {
    int level;
    std::array<std::int64_t, 3> voxel;  // z, y, x
    std::uint32_t index;
    auto operator<=>(const Key&) const = default;
  };
  std::vector<Key> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double side_m = std::max(finest_m, pixels * static_cast<double>(observations[i].footprint_m));
    const int level = static_cast<int>(std::lround(std::log2(side_m / finest_m)));
    const Eigen::Vector3d voxel =
        (points.position.col(static_cast<Eigen::Index>(i)).cast<double>() / std::ldexp(finest_m, level))
            .array()
            .floor();
    keys[i] = {level,
               {std::int64_t(voxel.z()), std::int64_t(voxel.y()), std::int64_t(voxel.x())},
               static_cast<std::uint32_t>(i)};
  }
  std::sort(keys.begin(), keys.end());

  PointSet out;
  out.position.resize(3, points.position.cols());
  std::vector<PointObservation> out_observations;
  for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d colour = Eigen::Vector3d::Zero();
    double intensity = 0.0;
    PointObservation closest = observations[keys[begin].index];
    for (; end < keys.size() && keys[end].level == keys[begin].level && keys[end].voxel == keys[begin].voxel;
         ++end) {
      const std::uint32_t i = keys[end].index;
      position += points.position.col(i).cast<double>();
      colour += observations[i].colour.cast<double>();
      intensity += static_cast<double>(points.intensity[i]);
      if (observations[i].range_m < closest.range_m) closest = observations[i];
    }
    const auto count = static_cast<double>(end - begin);
    closest.colour = (colour / count).cast<float>();
    out.position.col(static_cast<Eigen::Index>(out.size())) = (position / count).cast<float>();
    out.intensity.push_back(static_cast<float>(intensity / count));
    out_observations.push_back(closest);
  }
  out.position.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(out.size()));
  const std::size_t joined = points.size() - out.size();
  points = std::move(out);
  observations = std::move(out_observations);
  return joined;
}

FarShell::FarShell(double spacing_deg, double distance_m)
    : spacing_rad_(spacing_deg * std::numbers::pi / 180.0), distance_m_(distance_m) {
  if (!(spacing_deg >= 0.05 && spacing_deg <= 45.0)) {
    throw Error(ErrorKind::kUsage,
                fmt::format("shell_spacing_deg: found {}, allowed 0.05 to 45", spacing_deg));
  }
  if (!(distance_m > 0.0 && std::isfinite(distance_m))) {
    throw Error(ErrorKind::kUsage, fmt::format("shell distance: found {} m, allowed above 0", distance_m));
  }
  // Rings near the poles have fewer cells.
  for (double ring = 0.0; ring * spacing_rad_ <= std::numbers::pi; ring += 1.0) {
    const double elevation = (ring + 0.5) * spacing_rad_ - std::numbers::pi / 2.0;
    const double width = 2.0 * std::numbers::pi * std::max(std::cos(elevation), 0.0);
    cells_of_ring_.push_back(std::max(std::floor(width / spacing_rad_), 1.0));
  }
}

std::vector<FarObservation> far_observations(const ImageView& view,
                                             const Image& image,
                                             const Coverage& coverage) {
  const std::size_t count = coverage.covered.size(), columns = static_cast<std::size_t>(coverage.columns);
  std::vector<std::optional<FarObservation>> of_cell(count);
  parallel_each(
      count,
      [&](std::size_t i) {
        const auto row = static_cast<int>(i / columns), column = static_cast<int>(i % columns);
        // The picture's edge may cut off the last row and column of cells.
        const Eigen::Vector2d pixel{std::min((column + 0.5) * coverage.cell_px, image.width - 0.5),
                                    std::min((row + 0.5) * coverage.cell_px, image.height - 0.5)};
        FarObservation look;
        view.unproject(pixel, look.origin, look.direction);
        if (look.direction.isZero(0.0) || view.hides(pixel)) return;
        if (coverage.is_empty_around(column, row)) look.colour = sample_bilinear<3>(image, pixel);
        of_cell[i] = look;
      },
      kCellsPerThread);
  std::vector<FarObservation> out;
  for (const std::optional<FarObservation>& look : of_cell) {
    if (look) out.push_back(*look);
  }
  return out;
}

void FarShell::add(const std::vector<FarObservation>& observations) {
  for (const FarObservation& look : observations) {
    if (look.origin.norm() < distance_m_) continue;
    throw Error(
        ErrorKind::kInput,
        fmt::format("far shell: found a camera {:.3g} m from the middle of the path, allowed less than "
                    "{:.3g} m: are its mounting and the path right?",
                    look.origin.norm(),
                    distance_m_));
  }
  std::vector<Meeting> met(observations.size());
  parallel_each(
      observations.size(), [&](std::size_t i) { met[i] = meeting(observations[i]); }, kCellsPerThread);
  // In order, because sums are rounded.
  for (std::size_t i = 0; i < observations.size(); ++i) {
    Cell& cell = cells_[met[i].cell];
    if (!observations[i].colour) {
      cell.hidden += 1.0;
      continue;
    }
    cell.direction += met[i].from_origin;
    cell.colour += observations[i].colour->cast<double>();
    cell.open += 1.0;
  }
}

FarShell::Meeting FarShell::meeting(const FarObservation& look) const {
  // Where the ray leaves the sphere: |origin + t direction| = distance.
  const double b = look.origin.dot(look.direction);
  const double c = look.origin.squaredNorm() - distance_m_ * distance_m_;
  const double t = -b + std::sqrt(b * b - c);
  const Eigen::Vector3d from_origin = ((look.origin + t * look.direction) / distance_m_).normalized();
  const double elevation = std::atan2(from_origin.z(), std::hypot(from_origin.x(), from_origin.y()));
  const double azimuth = std::atan2(from_origin.y(), from_origin.x()) + std::numbers::pi;  // [0, 2 pi]
  const auto ring = static_cast<std::size_t>((elevation + std::numbers::pi / 2.0) / spacing_rad_);
  const double cells = cells_of_ring_[std::min(ring, cells_of_ring_.size() - 1)];
  const double cell = std::min(std::floor(azimuth / (2.0 * std::numbers::pi) * cells), cells - 1.0);
  return {from_origin, std::uint64_t{ring} << 32U | static_cast<std::uint64_t>(cell)};
}

std::vector<FarShell::Patch> FarShell::patches(double open_share) const {
  std::vector<std::pair<std::uint64_t, const Cell*>> sorted;
  for (const auto& [key, cell] : cells_) {
    const bool is_open = cell.open > 0.0 && cell.open >= open_share * (cell.open + cell.hidden);
    if (is_open) sorted.emplace_back(key, &cell);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<Patch> out;
  out.reserve(sorted.size());
  for (const auto& [key, cell] : sorted) {
    out.push_back({cell->direction.normalized().cast<float>(), (cell->colour / cell->open).cast<float>()});
  }
  return out;
}

}  // namespace simuli
