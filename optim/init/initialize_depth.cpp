#include "optim/init/initialize_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

constexpr int kPatchReach = 2;  // px of the halved picture: patches of 5 x 5
constexpr int kPatch = (2 * kPatchReach + 1) * (2 * kPatchReach + 1);
constexpr int kDistances = 64;          // steps of inverse distance
constexpr float kWorstCost = 0.10F;     // mean difference of grey values above which nothing matches
constexpr float kSameCost = 0.001F;     // costs this close are the same: the farther distance is taken
constexpr float kSameShare = 0.2F;      // of the best cost, on top: what is left there is noise
constexpr std::size_t kReach = 8;       // pictures before and after
constexpr double kApart_m = 0.5;        // between two of them, or
constexpr double kApart_rad = 0.1;      // turned by that: others tell little more
constexpr std::size_t kLeastViews = 2;  // that must agree

using Patch = std::array<float, kPatch>;

float sample(const Image& grey, float x, float y) {
  const float px = std::clamp(x - 0.5F, 0.0F, static_cast<float>(grey.width - 1));
  const float py = std::clamp(y - 0.5F, 0.0F, static_cast<float>(grey.height - 1));
  const int x0 = static_cast<int>(px);
  const int y0 = static_cast<int>(py);
  const int x1 = std::min(x0 + 1, grey.width - 1);
  const int y1 = std::min(y0 + 1, grey.height - 1);
  const float u = px - static_cast<float>(x0);
  const float v = py - static_cast<float>(y0);
  return (1.0F - v) * ((1.0F - u) * grey.at(x0, y0, 0) + u * grey.at(x1, y0, 0)) +
         v * ((1.0F - u) * grey.at(x0, y1, 0) + u * grey.at(x1, y1, 0));
}

/// Grey values around `centre` along the picture's axes, or along those that a warp gives.
Patch read_patch(const Image& grey,
                 const Eigen::Vector2f& centre,
                 const Eigen::Vector2f& x_axis,
                 const Eigen::Vector2f& y_axis) {
  Patch patch{};
  std::size_t at = 0;
  for (int dy = -kPatchReach; dy <= kPatchReach; ++dy) {
    for (int dx = -kPatchReach; dx <= kPatchReach; ++dx) {
      const Eigen::Vector2f p = centre + static_cast<float>(dx) * x_axis + static_cast<float>(dy) * y_axis;
      patch[at++] = sample(grey, p.x(), p.y());
    }
  }
  return patch;
}

float mean_difference(const Patch& a, const Patch& b) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<float>(kPatch);
}

/// Rays through a pixel and its right and lower neighbours: the patch as a small plane at any distance.
struct PatchRays {
  std::array<Eigen::Vector3d, 3> origin;
  std::array<Eigen::Vector3d, 3> direction;
};

PatchRays patch_rays(const ImageView& view, const Eigen::Vector2d& pixel) {
  const std::array<Eigen::Vector2d, 3> pixels = {
      pixel, pixel + Eigen::Vector2d::UnitX(), pixel + Eigen::Vector2d::UnitY()};
  PatchRays rays;
  for (std::size_t k = 0; k < 3; ++k) view.unproject(pixels[k], rays.origin[k], rays.direction[k]);
  return rays;
}

/// Step 0 lies beyond kSweepFarthest_m.
double distance_of(int step) {
  const double near = 1.0 / kSweepNearest_m;
  return step == 0 ? 10.0 * kSweepFarthest_m
                   : 1.0 / (1.0 / kSweepFarthest_m +
                            (near - 1.0 / kSweepFarthest_m) * (step - 1) / (kDistances - 2));
}

/// How much another picture differs from `patch` at that distance; nothing when it does not see it.
std::optional<float> cost_in(const SweepPicture& other,
                             const PatchRays& rays,
                             double distance_m,
                             const Patch& patch) {
  std::array<Eigen::Vector2d, 3> pixel;
  double range_m = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!other.view.project(rays.origin[k] + distance_m * rays.direction[k], pixel[k], range_m)) {
      return std::nullopt;
    }
  }
  const Eigen::Vector2f centre = pixel[0].cast<float>();
  return mean_difference(
      patch,
      read_patch(other.grey, centre, pixel[1].cast<float>() - centre, pixel[2].cast<float>() - centre));
}

/// Mean of the better half of the pictures: the others may have something in front.
float cost_at(const std::vector<const SweepPicture*>& others,
              const PatchRays& rays,
              double distance_m,
              const Patch& patch) {
  std::vector<float> costs;
  for (const SweepPicture* other : others) {
    if (const auto cost = cost_in(*other, rays, distance_m, patch)) costs.push_back(*cost);
  }
  if (costs.size() < kLeastViews) return std::numeric_limits<float>::infinity();
  std::sort(costs.begin(), costs.end());
  const std::size_t used = std::max(kLeastViews, (costs.size() + 1) / 2);
  float sum = 0.0F;
  for (std::size_t i = 0; i < used; ++i) sum += costs[i];
  return sum / static_cast<float>(used);
}

std::optional<Eigen::Vector3d> find_point(const SweepPicture& picture,
                                          const std::vector<const SweepPicture*>& others,
                                          const Eigen::Vector2d& pixel) {
  if (picture.view.hides(pixel)) return std::nullopt;
  const Patch patch =
      read_patch(picture.grey, pixel.cast<float>(), Eigen::Vector2f::UnitX(), Eigen::Vector2f::UnitY());
  const PatchRays rays = patch_rays(picture.view, pixel);
  for (const Eigen::Vector3d& direction : rays.direction) {
    if (direction.isZero()) return std::nullopt;  // outside the lens
  }
  std::array<float, kDistances> costs{};
  for (int i = 0; i < kDistances; ++i) {
    costs[static_cast<std::size_t>(i)] = cost_at(others, rays, distance_of(i), patch);
  }
  const float best = *std::min_element(costs.begin(), costs.end());
  if (!(best <= kWorstCost)) return std::nullopt;
  const auto first = std::find_if(
      costs.begin(), costs.end(), [best](float c) { return c <= (1.0F + kSameShare) * best + kSameCost; });
  if (first == costs.begin()) return std::nullopt;
  return rays.origin[0] + distance_of(static_cast<int>(first - costs.begin())) * rays.direction[0];
}

/// Those that are apart from the one before them.
std::vector<const ImageFrame*> apart(const Log& log,
                                     const LogCamera& camera,
                                     const std::vector<const ImageFrame*>& images) {
  std::vector<const ImageFrame*> out;
  Pose last;
  for (const ImageFrame* frame : images) {
    if (frame->camera != camera.model.name) continue;
    const Pose pose = log.world_from_rig.at(middle_s(*frame)) * camera.rig_from_camera;
    const bool is_apart = out.empty() || (pose.translation - last.translation).norm() >= kApart_m ||
                          pose.rotation.angularDistance(last.rotation) >= kApart_rad;
    if (!is_apart) continue;
    out.push_back(frame);
    last = pose;
  }
  return out;
}

}  // namespace

SweepPicture sweep_picture(const ImageView& view, const Image& image, SkyMask sky) {
  const Camera camera =
      view.camera().resized(std::max(1, (image.width + 1) / 2), std::max(1, (image.height + 1) / 2));
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
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < coverage.covered.size(); ++i) {
    const auto columns = static_cast<std::size_t>(coverage.columns);
    if (coverage.is_empty_around(static_cast<int>(i % columns), static_cast<int>(i / columns))) {
      cells.push_back(i);
    }
  }
  std::vector<std::optional<Eigen::Vector3d>> found(cells.size());
  const double scale_x = static_cast<double>(picture.grey.width) / picture.full_width;
  const double scale_y = static_cast<double>(picture.grey.height) / picture.full_height;
  constexpr std::size_t kCellsPerThread = 64;
  parallel_ranges(
      cells.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto column = static_cast<double>(cells[k] % static_cast<std::size_t>(coverage.columns));
          const auto row = static_cast<double>(cells[k] / static_cast<std::size_t>(coverage.columns));
          if (picture.sky.at(
                  Eigen::Vector2d{(column + 0.5) * coverage.cell_px, (row + 0.5) * coverage.cell_px}))
            continue;
          // The last row and column of cells may be cut off by the picture's edge.
          const Eigen::Vector2d pixel{
              std::min((column + 0.5) * coverage.cell_px * scale_x, picture.grey.width - 0.5),
              std::min((row + 0.5) * coverage.cell_px * scale_y, picture.grey.height - 0.5)};
          found[k] = find_point(picture, others, pixel);
        }
      },
      kCellsPerThread);
  std::vector<Eigen::Vector3d> points;
  for (const auto& point : found) {
    if (point) points.push_back(*point);
  }
  return points;
}

std::size_t PictureDepths::add_to(PointSet& points, const std::function<void()>& step) const {
  struct Loaded {
    SweepPicture picture;
    Coverage coverage;
  };
  VoxelGrid grid(2.0 * voxel_m);
  const PointBlocks blocks(points);
  for (const LogCamera& camera : log.cameras) {
    const std::vector<const ImageFrame*> frames = apart(log, camera, images);
    expect(log, frames, image_scale);
    std::deque<Loaded> window;  // frames [first, next)
    std::size_t first = 0, next = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      for (; next < frames.size() && next <= k + kReach; ++next) {
        const auto [image, view] = load_view(log, *frames[next], origin, image_scale);
        const PointSet placed =
            actors.placed(points.subset(blocks.seen_from(view)), middle_s(*frames[next]), view);
        std::vector<PointLook> unused(placed.size());
        Coverage coverage = look_at_points(view, image, placed, voxel_m, cell_px, unused);
        actors.cover(view, middle_s(*frames[next]), coverage);
        window.push_back({sweep_picture(view, image, sky.at(frames[next])), std::move(coverage)});
      }
      for (; first + kReach < k; ++first) window.pop_front();
      std::vector<const SweepPicture*> others;
      for (std::size_t i = 0; i < window.size(); ++i) {
        if (first + i != k) others.push_back(&window[i].picture);
      }
      const Loaded& here = window[k - first];
      for (const Eigen::Vector3d& p : sweep_depths(here.picture, others, here.coverage)) grid.add(p, 0.0);
      step();
    }
    const auto all = std::count_if(images.begin(), images.end(), [&camera](const ImageFrame* frame) {
      return frame->camera == camera.model.name;
    });
    for (std::size_t k = frames.size(); k < static_cast<std::size_t>(all); ++k) step();
  }
  const PointSet found = grid.averages();
  points.append(found);
  return found.size();
}

}  // namespace simuli
