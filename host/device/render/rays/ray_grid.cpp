#include "host/device/render/rays/ray_grid.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"
#include "host/core/base/interruption.hpp"
#include "host/device/render/rays/ray_slots.hpp"

namespace simuli {
namespace {

/// Upper bounds of the derivatives of a lens's image over a cone about its axis.
struct LensSlopes {
  double cone_rad = 0.0;
  // px per rad; the default makes every bound the whole picture.
  Eigen::Array2d slope = Eigen::Array2d::Constant(1e30);
  Eigen::Array2d bend = Eigen::Array2d::Constant(1e30);  // px per rad^2 along great circles
};

/// Adds the largest first and second derivatives of the pixel's x and y over the directions at `angle` to the
/// axis to `slopes`; false where the lens's formula is not smooth. The formula may extend beyond a fold: rays
/// end there, but it still bounds their pixels over a convex cone.
bool add_slopes(const Camera& camera, double angle, LensSlopes& slopes) {
  constexpr int kAround = 72;
  constexpr double kStep = 5e-4;  // rad
  const double s = std::sin(kStep), c = std::cos(kStep), diagonal = std::sqrt(0.5);
  const auto image = [&camera](const Eigen::Vector3d& direction, Eigen::Vector2d& pixel) {
    if (!camera.lens.continued(direction, pixel)) return false;
    pixel = pixel.cwiseProduct(Eigen::Vector2d(camera.fx, camera.fy));
    return true;
  };
  for (int k = 0; k < kAround; ++k) {
    const double phi = 2.0 * kPi * k / kAround;
    const Eigen::Vector3d outwards(std::cos(phi), std::sin(phi), 0.0);
    const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d here = std::sin(angle) * outwards + std::cos(angle) * axis;
    const Eigen::Vector3d u = std::cos(angle) * outwards - std::sin(angle) * axis;
    const Eigen::Vector3d v = axis.cross(outwards);
    Eigen::Vector2d middle;
    if (!image(here, middle)) return false;
    // Derivatives at `here` along the great circle in direction `along`.
    Eigen::Array2d first[3], second[3];
    const Eigen::Vector3d along[3] = {u, v, diagonal * (u + v)};
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector2d ahead, behind;
      if (!(image(c * here + s * along[i], ahead) && image(c * here - s * along[i], behind))) {
        return false;
      }
      first[i] = (ahead - behind).array() / (2.0 * kStep);
      second[i] = (ahead + behind - 2.0 * middle).array() / (kStep * kStep);
    }
    slopes.slope = slopes.slope.max((first[0].square() + first[1].square()).sqrt());
    // The larger eigenvalue of [[uu, uv], [uv, vv]] in magnitude; the diagonal direction gives the mixed
    // derivative.
    const Eigen::Array2d mixed = second[2] - 0.5 * (second[0] + second[1]);
    const Eigen::Array2d apart = 0.5 * (second[0] - second[1]);
    const Eigen::Array2d mean = 0.5 * (second[0] + second[1]).abs();
    slopes.bend = slopes.bend.max(mean + (apart.square() + mixed.square()).sqrt());
  }
  return true;
}

/// The cone contains all rays (picture_rad) and, as far as the lens reaches, a margin for wide or moving
/// particles outside the picture. A cone below a half space is convex, as required; it then extends only as far
/// as the picture's own derivatives allow, because polynomials diverge beyond the picture's edge.
LensSlopes lens_slopes(const Camera& camera, double picture_rad) {
  constexpr double kStep = 0.25 * kPi / 180.0;
  constexpr double kBetweenSamples = 1.02;  // factor for the variation of the smooth map between samples
  constexpr double kConvexMargin = 0.15, kMargin = 0.5;
  constexpr double kSteeper = 1.1;
  const bool convex = picture_rad <= 0.5 * kPi;
  const double farthest = convex ? std::min(picture_rad + kConvexMargin, 0.5 * kPi)
                                 : std::min(picture_rad + kMargin, kPi - kStep);
  LensSlopes slopes{0.0, Eigen::Array2d::Zero(), Eigen::Array2d::Zero()}, of_picture = slopes;
  while (slopes.cone_rad < farthest) {
    const bool beside = slopes.cone_rad >= picture_rad;
    const double angle = std::min(slopes.cone_rad + kStep, beside ? farthest : picture_rad);
    LensSlopes wider = slopes;
    if (!add_slopes(camera, angle, wider)) break;
    if (convex && beside &&
        ((wider.slope > kSteeper * of_picture.slope).any() ||
         (wider.bend > kSteeper * of_picture.bend).any())) {
      break;
    }
    slopes = wider;
    slopes.cone_rad = angle;
    if (!beside) of_picture = slopes;
  }
  if (convex && slopes.cone_rad < picture_rad) return {picture_rad};
  slopes.slope *= kBetweenSamples;
  slopes.bend *= kBetweenSamples * kBetweenSamples;
  return slopes;
}

}  // namespace

RayGrid make_ray_grid(const Camera& camera, const RayOptions& options) {
  RayGrid grid;
  grid.type = SensorType::kCamera;
  grid.lens = camera.lens.kind();
  grid.width = camera.width;
  grid.height = camera.height;
  const bool wraps = grid.lens == LensKind::kEquirectangular;
  grid.rays = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  auto& frame = grid.frame;
  frame.tiles_x = static_cast<std::uint32_t>((camera.width + SIM_TILE_SIDE - 1) / SIM_TILE_SIDE);
  frame.tiles_y = static_cast<std::uint32_t>((camera.height + SIM_TILE_SIDE - 1) / SIM_TILE_SIDE);
  frame.rows = static_cast<std::uint32_t>(camera.height);
  frame.tile_rays = SIM_TILE_RAYS;
  frame.row_slots = 0;
  static_assert(kLargestSide_px <= SIM_MOST_TILE_COLUMNS * SIM_TILE_SIDE);
  ray_slots::allocate(grid);
  for (std::uint32_t row = 0; row < frame.rows; row += SIM_TILE_SIDE) grid.tile_rows.push_back(row);
  grid.tile_rows.push_back(frame.rows);
  double lowest_cosine = 1.0;  // of the cone about the optical axis that contains all rays
  for (int y = 0; y < camera.height; ++y) {
    Interruption::ask();
    for (int x = 0; x < camera.width; ++x) {
      const std::size_t slot = SIM_SLOT_OF_ROW(static_cast<std::size_t>(y), frame.tiles_x) +
                               SIM_SLOT_OF_COLUMN(static_cast<std::size_t>(x));
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      const std::size_t ray =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x);
      grid.u[slot] = static_cast<float>(pixel.x());
      const Eigen::Vector3d direction = camera.unproject(pixel);
      if (direction.isZero(0.0)) {
        ++grid.without_ray;
        continue;
      }
      lowest_cosine = std::min(lowest_cosine, direction.z());
      ray_slots::set_ray(
          grid, slot, ray, direction, Eigen::Vector3d::Zero(), camera.exposure_fraction(pixel));
    }
  }
  if (grid.without_ray == grid.rays) {
    throw_input_error("camera " + camera.name, "lens", "no pixel with a ray", "at least one");
  }
  auto& m = grid.model;
  m.lens = camera.lens.constants();
  grid.windshield = static_cast<int>(m.lens.bend);
  m.fx = camera.fx;
  m.fy = camera.fy;
  m.cx = camera.cx;
  m.cy = camera.cy;
  m.picture_width = camera.width;
  m.picture_height = camera.height;
  m.last_column = camera.width - 1;
  m.last_row = camera.height - 1;
  grid.view_angle = std::acos(std::max(lowest_cosine, -1.0));
  if (grid.lens != LensKind::kPinhole && !wraps) {
    const LensSlopes slopes = lens_slopes(camera, grid.view_angle);
    m.lens_cone = slopes.cone_rad;
    m.lens_slope[0] = slopes.slope.x();
    m.lens_slope[1] = slopes.slope.y();
    m.lens_bend[0] = slopes.bend.x();
    m.lens_bend[1] = slopes.bend.y();
  }
  m.time_c = camera.exposure_fraction({0.0, 0.0});
  m.time_x = camera.exposure_fraction({1.0, 0.0}) - m.time_c;
  m.time_y = camera.exposure_fraction({0.0, 1.0}) - m.time_c;
  m.time_step = std::abs(m.time_x) + std::abs(m.time_y);
  m.rays_per_rad = camera.focal_px();
  m.kappa = camera_filter_px2(options) / (camera.focal_px() * camera.focal_px());
  m.t_min = options.camera_near_m;
  m.t_max = 1e6;
  m.period = wraps ? camera.width : 0.0;
  return grid;
}

namespace {

/// Azimuth at which the sweep starts: half a column before the first.
double azimuth_cut(const Lidar& lidar) {
  return lidar.azimuth_first - lidar.spin_sign() * 0.5 * lidar.azimuth_span / lidar.columns;
}

/// Unrolled spin angle since the sweep's start of every ray: the period nearest to the ray's time. Tiles, rays
/// and boxes use this coordinate along the spin (METHOD section 3, the seam).
std::vector<double> spin_angles(const Lidar& lidar, const LidarRays& rays) {
  const double cut = azimuth_cut(lidar);
  std::vector<double> angles(rays.azimuth.size());
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double by_time = static_cast<double>(rays.time_fraction[i]) * lidar.azimuth_span;
    const double turned = lidar.spin_sign() * (static_cast<double>(rays.azimuth[i]) - cut);
    angles[i] = by_time + std::remainder(turned - by_time, 2.0 * kPi);
  }
  return angles;
}

/// Largest difference between the rays' times and the times of their spin angles, as a share of the frame.
double time_spread(const Lidar& lidar, const LidarRays& rays, const std::vector<double>& angles) {
  constexpr double kRounding = 1e-6;  // of times in float
  double spread = 0.0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double reported = angles[i] / lidar.azimuth_span;
    spread = std::max(spread, std::abs(static_cast<double>(rays.time_fraction[i]) - reported));
  }
  return spread > kRounding ? spread : 0.0;
}

/// Largest difference between the rays' elevations and their rows': 0 unless measured.
double row_spread(const Lidar& lidar, const LidarRays& rays) {
  double spread = 0.0;
  for (std::size_t i = 0; i < rays.elevation.size(); ++i) {
    const double nominal = lidar.rows[i / static_cast<std::size_t>(rays.columns)].elevation;
    spread = std::max(spread, std::abs(static_cast<double>(rays.elevation[i]) - nominal));
  }
  return spread;
}

/// Sets the origins of the beams: mean height, and the largest distance from it.
void set_origins(RayGrid& grid, const Lidar& lidar) {
  double height = 0.0, up = 0.0, sideways = 0.0;
  for (const LidarRow& row : lidar.rows)
    height += row.vertical_offset / static_cast<double>(lidar.rows.size());
  for (const LidarRow& row : lidar.rows) {
    up = std::max(up, std::abs(row.vertical_offset - height));
    sideways = std::max(sideways, std::hypot(row.horizontal_offset, row.radial_offset));
    grid.lever_arms = grid.lever_arms || row.vertical_offset != 0.0;
  }
  grid.lever_arms = grid.lever_arms || sideways != 0.0;
  grid.model.height = height;
  grid.model.lever = up + sideways;
}

}  // namespace

RayGrid make_ray_grid(const Device& device, const Lidar& lidar, const LidarRays& rays) {
  const std::size_t count = lidar.rows.size() * static_cast<std::size_t>(rays.columns);
  if (rays.rows != lidar.row_count() || rays.columns < 1 || rays.azimuth.size() != count ||
      rays.elevation.size() != count || rays.time_fraction.size() != count) {
    throw_input_error("lidar " + lidar.name,
                      "rays",
                      fmt::format("{} x {}", rays.rows, rays.columns),
                      fmt::format("{} beams, three values per ray", lidar.row_count()));
  }
  const auto usable = [](float value) { return std::abs(value) <= 1e3F; };  // false for NaN
  for (std::size_t ray = 0; ray < count; ++ray) {
    if (!(usable(rays.azimuth[ray]) && usable(rays.elevation[ray]) && usable(rays.time_fraction[ray]))) {
      throw_input_error("lidar " + lidar.name,
                        fmt::format("ray {}", ray),
                        fmt::format("azimuth {}, elevation {}, time {}",
                                    rays.azimuth[ray],
                                    rays.elevation[ray],
                                    rays.time_fraction[ray]),
                        "numbers of at most 1000");
    }
  }
  RayGrid grid;
  grid.type = SensorType::kLidar;
  grid.rays = count;
  const std::vector<double> angles = spin_angles(lidar, rays);
  std::vector<double> elevations;
  for (const LidarRow& row : lidar.rows) elevations.push_back(row.elevation);
  const LidarTiles tiling = tile_rows_of_rays(
      device, lidar.name, {elevations.begin(), elevations.end()}, {angles.begin(), angles.end()});
  ray_slots::set_tiles(grid, tiling);
  ray_slots::fill_elevation_table(grid, elevations, elevations);
  set_origins(grid, lidar);
  for (std::size_t ray = 0; ray < count; ++ray) {
    const std::size_t slot = tiling.slot_of_ray[ray];
    const double azimuth = static_cast<double>(rays.azimuth[ray]);
    ray_slots::set_ray(grid,
                       slot,
                       ray,
                       Lidar::direction(azimuth, static_cast<double>(rays.elevation[ray])),
                       lidar.origin(static_cast<int>(ray / static_cast<std::size_t>(rays.columns)), azimuth),
                       static_cast<double>(rays.time_fraction[ray]));
    grid.u[slot] = static_cast<float>(angles[ray]);
  }
  auto& m = grid.model;
  m.azimuth_cut = azimuth_cut(lidar);
  m.spin = lidar.spin_sign();
  m.inv_span = 1.0 / lidar.azimuth_span;
  m.time_step = 1.0 / lidar.columns;
  m.time_spread = time_spread(lidar, rays, angles);
  m.row_spread = row_spread(lidar, rays);
  const auto [lowest, highest] = std::minmax_element(elevations.begin(), elevations.end());
  m.rays_per_rad = ray_slots::rays_per_rad(count, *lowest, *highest, lidar.azimuth_span);
  m.kappa = ray_slots::beam_variance(lidar.beam_divergence, lidar.divergence_variance);
  m.t_min = lidar.range_min;
  m.t_max = lidar.range_max;
  return grid;
}

}  // namespace simuli
