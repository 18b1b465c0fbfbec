#include "optim/train/chunk/chunks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include "host/core/base/error.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/point_tree.hpp"

namespace simuli {
namespace {

// A sensor's view of a chunk is sampled with this many rays, at these fractions of the overlap.
constexpr int kColumns = 6, kRows = 4;  // rays of a picture
constexpr std::size_t kRays = 61;  // rays of a sweep; not a multiple of its rows
constexpr std::array<double, 4> kParts{0.1, 0.2, 0.4, 0.8};
constexpr double kStep_m = 0.5;  // spacing of the path positions at which distance is evaluated

struct Span {
  double first_s = std::numeric_limits<double>::infinity();
  double last_s = -std::numeric_limits<double>::infinity();
  template <class Frame>
  void add(const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) {
      first_s = std::min(first_s, frame.time_start_s);
      last_s = std::max(last_s, frame.time_end_s);
    }
  }
};

/// Interpolates f linearly between the points (x[i], y[i]), x ascending; constant beyond the ends.
double between(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  const double share = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] + share * (y[i] - y[i - 1]);
}

std::string_view sensor_of(const ImageFrame& frame) { return frame.camera; }
std::string_view sensor_of(const SweepFrame& frame) { return frame.lidar; }

/// A sample of a sensor's rays in the rig's frame.
struct RigRays {
  Eigen::Vector3d origin;
  std::vector<Eigen::Vector3d> directions;
};

RigRays some_rays(const LogCamera& camera) {
  RigRays out{camera.rig_from_camera.translation, {}};
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel{(column + 0.5) * camera.model.width / kColumns,
                                  (row + 0.5) * camera.model.height / kRows};
      const Eigen::Vector3d direction = camera.model.unproject(pixel);
      if (!direction.isZero(0.0)) out.directions.emplace_back(camera.rig_from_camera.rotation * direction);
    }
  }
  return out;
}

RigRays some_rays(const LogLidar& lidar) {
  RigRays out{lidar.rig_from_lidar.translation, {}};
  const LidarRays rays = nominal_rays(lidar.model);
  const std::size_t count = rays.azimuth.size(), some = std::min(count, kRays);
  for (std::size_t k = 0; k < some; ++k) {
    const std::size_t i = (2 * k + 1) * count / (2 * some);
    out.directions.emplace_back(lidar.rig_from_lidar.rotation *
                                Lidar::direction(rays.azimuth[i], rays.elevation[i]));
  }
  return out;
}

/// Computes the share of a sensor's view that shows a chunk.
class ChunkVisibility {
 public:
  ChunkVisibility(const Log& log, const DrivenPath& path, const DriveChunk& chunk, double overlap_m)
      : log_(log),
        path_(path),
        chunk_(chunk),
        overlap_m_(overlap_m),
        origin_(scene_origin(log.world_from_rig)) {
    for (const LogCamera& camera : log.cameras) rays_[camera.model.name] = some_rays(camera);
    for (const LogLidar& lidar : log.lidars) rays_[name_of(lidar.model)] = some_rays(lidar);
  }
  /// Returns the share of sample points along the sensor's rays, up to the overlap length, that are nearest to
  /// this chunk.
  [[nodiscard]] double share(std::string_view sensor, double time_s) const {
    const RigRays& rays = rays_.at(sensor);
    Pose scene_from_rig = log_.world_from_rig.at(time_s);
    scene_from_rig.translation -= origin_;
    double own = 0.0, all = 0.0;
    for (const Eigen::Vector3d& direction : rays.directions) {
      for (const double part : kParts) {
        const Eigen::Vector3d p = scene_from_rig * (rays.origin + part * overlap_m_ * direction);
        const double position_m = path_.place_nearest(p.cast<float>());
        const bool is_own =
            position_m >= chunk_.from_m && (position_m < chunk_.to_m || chunk_.to_m >= path_.length_m());
        if (is_own) ++own;
        ++all;
      }
    }
    return own / std::max(all, 1.0);
  }

 private:
  const Log& log_;
  const DrivenPath& path_;
  const DriveChunk& chunk_;
  double overlap_m_;
  Eigen::Vector3d origin_;
  std::map<std::string_view, RigRays> rays_;
};

template <class Frame>
std::vector<Frame> frames_of(const std::vector<Frame>& all,
                             const HeldOutRule& rule,
                             const DrivenPath& path,
                             const DriveChunk& chunk,
                             const ChunkOptions& options,
                             const ChunkVisibility& sight) {
  std::vector<Frame> out;
  std::map<std::string_view, double> due;  // frames outside the chunk still to be added, by sensor
  for (const std::size_t i : rule.training(all)) {
    const double middle_s = 0.5 * (all[i].time_start_s + all[i].time_end_s);
    const double position_m = path.place_at(middle_s);
    const double away_m = std::max(chunk.from_m - position_m, position_m - chunk.to_m);
    if (away_m > options.overlap_m) continue;
    if (away_m > 0.0) {
      double& sum = due.try_emplace(sensor_of(all[i]), 0.5).first->second;
      const double before = std::floor(sum);
      sum += options.overlap_share * sight.share(sensor_of(all[i]), middle_s);
      if (std::floor(sum) == before) continue;
    }
    out.push_back(all[i]);
  }
  return out;
}

}  // namespace

/// Positions along the path and a search tree of them.
struct DrivenPath::Search {
  Search(const std::vector<Eigen::Vector3f>& places, std::vector<double> along) : along_m(std::move(along)) {
    points.position.resize(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i) {
      points.position.col(static_cast<Eigen::Index>(i)) = places[i];
    }
    points.intensity.assign(places.size(), 0.0F);
    tree.buildIndex();
  }
  std::vector<double> along_m;
  PointSet points;
  CloudView cloud{points};
  PointTree tree{3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)};
};

DrivenPath::DrivenPath(const Log& log) {
  Span span;
  span.add(log.images);
  span.add(log.sweeps);
  if (span.first_s > span.last_s || log.world_from_rig.poses().empty()) {
    throw_input_error(log.folder.string(), "frames along a path", "0", "at least one image or sweep");
  }
  const Eigen::Vector3d origin = scene_origin(log.world_from_rig);
  std::vector<Eigen::Vector3d> centres;
  const auto add = [&](double time_s) {
    const Eigen::Vector3d centre = log.world_from_rig.at(time_s).translation - origin;
    if (!centres.empty()) length_m_ += (centre - centres.back()).norm();
    centres.push_back(centre);
    time_s_.push_back(time_s);
    position_m_.push_back(length_m_);
    farthest_m_ = std::max(farthest_m_, centre.norm());
  };
  add(span.first_s);
  for (const TimedPose& pose : log.world_from_rig.poses()) {
    if (pose.time_s > span.first_s && pose.time_s < span.last_s) add(pose.time_s);
  }
  if (span.last_s > span.first_s) add(span.last_s);
  std::vector<Eigen::Vector3f> places;
  std::vector<double> along;
  for (std::size_t i = 0; i + 1 < centres.size(); ++i) {
    const double step_m = position_m_[i + 1] - position_m_[i];
    for (double k = std::ceil(position_m_[i] / kStep_m); k * kStep_m < position_m_[i + 1]; ++k) {
      const double share = (k * kStep_m - position_m_[i]) / step_m;
      places.emplace_back((centres[i] + share * (centres[i + 1] - centres[i])).cast<float>());
      along.push_back(k * kStep_m);
    }
  }
  places.emplace_back(centres.back().cast<float>());
  along.push_back(length_m_);
  search_ = std::make_unique<Search>(places, std::move(along));
}

DrivenPath::~DrivenPath() = default;

double DrivenPath::place_at(double time_s) const { return between(time_s_, position_m_, time_s); }

double DrivenPath::place_nearest(const Eigen::Vector3f& p_scene) const {
  std::uint32_t index = 0;
  float distance2 = 0.0F;
  search_->tree.knnSearch(p_scene.data(), 1, &index, &distance2);
  return search_->along_m[index];
}

std::vector<Eigen::Vector3d> DrivenPath::places_of(const DriveChunk& chunk, double step_m) const {
  std::vector<std::size_t> within;
  for (std::size_t i = 0; i < search_->along_m.size(); ++i) {
    if (search_->along_m[i] >= chunk.from_m && search_->along_m[i] <= chunk.to_m) within.push_back(i);
  }
  const auto place = [&](std::size_t i) -> Eigen::Vector3d {
    return search_->points.position.col(static_cast<Eigen::Index>(i)).cast<double>();
  };
  if (within.empty()) {  // between two path positions
    const auto next = std::lower_bound(search_->along_m.begin(), search_->along_m.end(), chunk.from_m);
    const auto last = static_cast<std::ptrdiff_t>(search_->along_m.size()) - 1;
    return {place(static_cast<std::size_t>(std::min(next - search_->along_m.begin(), last)))};
  }
  const auto each = static_cast<std::size_t>(std::max(std::round(step_m / kStep_m), 1.0));
  std::vector<Eigen::Vector3d> out;
  for (std::size_t k = 0; k + 1 < within.size(); k += each) out.push_back(place(within[k]));
  out.push_back(place(within.back()));
  return out;
}

std::vector<DriveChunk> cut(const DrivenPath& path, const ChunkOptions& options) {
  const double wanted = options.length_m > 0.0 ? std::round(path.length_m() / options.length_m) : 1.0;
  const auto count = static_cast<std::size_t>(std::max(wanted, 1.0));
  std::vector<DriveChunk> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    out[i].from_m = path.length_m() * static_cast<double>(i) / static_cast<double>(count);
    out[i].to_m = path.length_m() * static_cast<double>(i + 1) / static_cast<double>(count);
  }
  return out;
}

std::size_t chunk_at(const std::vector<DriveChunk>& chunks, double position_m) {
  const auto behind =
      std::upper_bound(chunks.begin(), chunks.end(), position_m, [](double place, const DriveChunk& s) {
        return place < s.to_m;
      });
  return std::min(static_cast<std::size_t>(behind - chunks.begin()), chunks.size() - 1);
}

std::vector<int> ends_of(int iterations, const std::vector<std::size_t>& pictures) {
  const auto total = static_cast<double>(std::accumulate(pictures.begin(), pictures.end(), std::size_t{0}));
  std::vector<int> ends;
  double so_far = 0.0;
  for (const std::size_t own : pictures) {
    so_far += static_cast<double>(own);
    ends.push_back(static_cast<int>(std::lround(iterations * so_far / std::max(total, 1.0))));
  }
  return ends;
}

Log log_of(const Log& log,
           const FrameSelection& frames,
           const DrivenPath& path,
           const DriveChunk& chunk,
           const ChunkOptions& options) {
  Log out = log;
  const HeldOutRule rule(log, frames);
  const ChunkVisibility sight(log, path, chunk, options.overlap_m);
  out.images = frames_of(log.images, rule, path, chunk, options, sight);
  out.sweeps = frames_of(log.sweeps, rule, path, chunk, options, sight);
  Span span;
  span.add(out.images);
  span.add(out.sweeps);
  std::erase_if(out.actors, [&span](const Actor& actor) {
    return actor.track.back().time_s + Actor::kReach_s < span.first_s ||
           actor.track.front().time_s - Actor::kReach_s > span.last_s;
  });
  return out;
}

}  // namespace simuli
