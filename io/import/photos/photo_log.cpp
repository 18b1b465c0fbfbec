#include "io/import/photos/photo_log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <system_error>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/spread.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/log/new_log.hpp"
#include "io/picture/sized_image.hpp"
#include "io/splat/cloud_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr double kPointDistance_m = 10.0;
constexpr double kStep_m = 0.5;
constexpr double kFarthest = 100.0;  // farther points, in multiples of the typical distance, are outliers

/// Returns the distance of each point (at most some thousand) from the nearest photograph.
std::vector<double> point_distances(const PhotoSet& set) {
  constexpr std::size_t kMost = 2000;
  const std::size_t step = std::max<std::size_t>(1, set.points.size() / kMost);
  std::vector<double> distances;
  for (std::size_t i = 0; i < set.points.size(); i += step) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Photo& photo : set.photos) {
      nearest = std::min(nearest, (set.points[i] - photo.world_from_camera.translation).norm());
    }
    distances.push_back(nearest);
  }
  return distances;
}

double usual_scale(const PhotoSet& set) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < set.photos.size(); ++i) {
    steps.push_back(
        (set.photos[i].world_from_camera.translation - set.photos[i - 1].world_from_camera.translation)
            .norm());
  }
  const double distance = upper_median(point_distances(set));
  if (distance > 0.0) return kPointDistance_m / distance;
  const double step = upper_median(steps);
  return step > 0.0 ? kStep_m / step : 1.0;
}

/// Returns the smallest rotation that maps the photographs' mean up direction to +z.
Eigen::Quaterniond levelled(const PhotoSet& set) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Photo& photo : set.photos) up -= photo.world_from_camera.rotation * Eigen::Vector3d::UnitY();
  if (!(up.norm() > 0.1 * static_cast<double>(set.photos.size()))) return Eigen::Quaterniond::Identity();
  return turn_between(up, Eigen::Vector3d::UnitZ());
}

/// Scales cameras to the size of their photographs, if these are downscaled versions of the full picture.
void resize_cameras(PhotoSet& set) {
  std::vector<bool> is_known(set.cameras.size());
  for (const Photo& photo : set.photos) {
    if (is_known[photo.camera]) continue;
    is_known[photo.camera] = true;
    Camera& camera = set.cameras[photo.camera];
    const auto [width, height] = size_of_image(photo.file);
    const double ratio = static_cast<double>(width) / camera.width;
    if (3 * width > 2 * camera.width || std::abs(ratio * camera.height - height) > 1.0) continue;
    set.notes.push_back(fmt::format("{}: {} x {} px as its photographs, not {} x {}",
                                    camera.name,
                                    width,
                                    height,
                                    camera.width,
                                    camera.height));
    camera = camera.resized(width, height);
  }
}

void keep_present(PhotoSet& set, PhotoReport& report) {
  const auto twice = std::unique(
      set.photos.begin(), set.photos.end(), [](const Photo& a, const Photo& b) { return a.file == b.file; });
  if (twice != set.photos.end()) {
    set.notes.push_back(fmt::format("{} photographs are named again, with poses that are left out",
                                    std::distance(twice, set.photos.end())));
    set.photos.erase(twice, set.photos.end());
  }
  const auto is_absent = [](const Photo& photo) {
    std::error_code ignored;
    return !fs::exists(photo.file, ignored);
  };
  const fs::path first = set.photos.empty() ? "" : set.photos.front().file;
  report.absent = std::erase_if(set.photos, is_absent);
  if (set.photos.empty()) {
    (report.absent > 0 ? throw_nothing_left : throw_input_error)(
        set.source,
        "photographs",
        fmt::format(
            "none of {}{}", report.absent, first.empty() ? "" : ", of which the first is " + first.string()),
        "at least one");
  }
}

PointCloud cloud_of(const PhotoSet& set, double typical_m) {
  PointCloud cloud;
  cloud.columns = {"x", "y", "z"};
  cloud.values.resize(static_cast<Eigen::Index>(set.points.size()), 3);
  Eigen::Index row = 0;
  for (const Eigen::Vector3d& p : set.points) {
    if (!p.allFinite() || !(p.norm() <= kFarthest * typical_m)) continue;
    cloud.values.row(row++) = p;
  }
  cloud.values.conservativeResize(row, 3);
  return cloud;
}

}  // namespace

bool is_before(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto run = [&](const std::string& text, std::size_t& at) {
    const std::size_t from = std::min(text.find_first_not_of('0', at), text.size());
    for (at = from; at < text.size() && is_digit(text[at]);) ++at;
    return text.substr(from, at - from);
  };
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (is_digit(a[i]) && is_digit(b[k])) {
      const std::string x = run(a, i), y = run(b, k);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a[i] != b[k]) {
      return a[i] < b[k];
    } else {
      ++i;
      ++k;
    }
  }
  if ((i < a.size()) != (k < b.size())) return k < b.size();
  return a < b;
}

Log write_photo_log(PhotoSet set,
                    double metres_per_unit,
                    const fs::path& output,
                    const FrameProgress& progress,
                    PhotoReport& report) {
  keep_present(set, report);
  resize_cameras(set);
  report.photos = set.photos.size();
  report.notes = set.notes;
  report.metres_per_unit = metres_per_unit > 0.0 ? metres_per_unit : usual_scale(set);
  const Eigen::Quaterniond turn = set.level ? levelled(set) : Eigen::Quaterniond::Identity();
  // Relative to the centre of the photographs, so that float coordinates are accurate.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Photo& p : set.photos) middle += p.world_from_camera.translation;
  middle /= static_cast<double>(set.photos.size());
  const auto placed = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return turn * (report.metres_per_unit * (p - middle));
  };
  std::vector<TimedPose> path;
  double farthest_m = kPointDistance_m;
  for (std::size_t i = 0; i < set.photos.size(); ++i) {
    Pose world_from_camera = set.photos[i].world_from_camera;
    world_from_camera = {turn * world_from_camera.rotation, placed(world_from_camera.translation)};
    farthest_m = std::max(farthest_m, world_from_camera.translation.norm());
    path.push_back(
        {static_cast<double>(i), world_from_camera * Pose{kForwardFromCamera.conjugate(), {0, 0, 0}}});
  }
  for (Eigen::Vector3d& p : set.points) p = placed(p);

  Log log;
  log.name = name_from((fs::current_path() / (output.empty() ? fs::path(set.source) : output))
                           .lexically_normal()
                           .stem()
                           .string());
  log.world_from_rig = Trajectory(std::move(path));
  for (const Camera& camera : set.cameras) log.cameras.push_back({camera, {kForwardFromCamera, {0, 0, 0}}});
  return make_import(output, log, [&] {
    LogMaker maker(log, progress, set.photos.size());
    for (std::size_t i = 0; i < set.photos.size(); ++i) {
      const Camera& camera = set.cameras[set.photos[i].camera];
      const auto time_s = static_cast<double>(i);
      maker.add_picture(
          camera, fmt::format("{:06}", i), set.photos[i].file, "camera " + camera.name, {time_s, time_s});
      maker.step();
    }
    if (!set.points.empty()) {
      log.points = "points.ply";
      const PointCloud cloud = cloud_of(set, farthest_m);
      report.points = static_cast<std::size_t>(cloud.values.rows());
      put_file(log, log.points, [&](const fs::path& to) { write_point_cloud(to, cloud); });
    }
  });
}

}  // namespace simuli
