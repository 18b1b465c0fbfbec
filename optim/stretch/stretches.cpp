#include "optim/stretch/stretches.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include "host/base/error.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/points/point_tree.hpp"

namespace simuli {
namespace {

constexpr double kSteps =
    10.0;  // from all frames beside a stretch to every eleventh at the end of the overlap
constexpr double kStep_m = 0.5;  // between the places that nearness is asked of

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

/// f(x), linear between the points (x[i], y[i]), x ascending; the ends' values beyond.
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

/// Of the frames beside a stretch every so many are taken, the fewer the farther away.
std::size_t step_at(double away_m, double overlap_m) {
  return away_m <= 0.0 ? 1 : 1 + static_cast<std::size_t>(kSteps * away_m / overlap_m);
}

template <class Frame>
std::vector<Frame> frames_of(const std::vector<Frame>& all,
                             const HeldOutRule& rule,
                             const DrivenPath& path,
                             const Stretch& stretch,
                             double overlap_m) {
  std::vector<Frame> out;
  std::map<std::string_view, std::size_t> numbers;
  for (const std::size_t i : rule.training(all)) {
    const std::size_t number = numbers[sensor_of(all[i])]++;
    const double place_m = path.place_at(0.5 * (all[i].time_start_s + all[i].time_end_s));
    const double away_m = std::max(stretch.from_m - place_m, place_m - stretch.to_m);
    if (away_m <= overlap_m && number % step_at(away_m, overlap_m) == 0) out.push_back(all[i]);
  }
  return out;
}

}  // namespace

/// Places along the path, and a tree of them.
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
    place_m_.push_back(length_m_);
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
    const double step_m = place_m_[i + 1] - place_m_[i];
    for (double k = std::ceil(place_m_[i] / kStep_m); k * kStep_m < place_m_[i + 1]; ++k) {
      const double share = (k * kStep_m - place_m_[i]) / step_m;
      places.emplace_back((centres[i] + share * (centres[i + 1] - centres[i])).cast<float>());
      along.push_back(k * kStep_m);
    }
  }
  places.emplace_back(centres.back().cast<float>());
  along.push_back(length_m_);
  search_ = std::make_unique<Search>(places, std::move(along));
}

DrivenPath::~DrivenPath() = default;

double DrivenPath::place_at(double time_s) const { return between(time_s_, place_m_, time_s); }

double DrivenPath::place_nearest(const Eigen::Vector3f& p_scene) const {
  std::uint32_t index = 0;
  float distance2 = 0.0F;
  search_->tree.knnSearch(p_scene.data(), 1, &index, &distance2);
  return search_->along_m[index];
}

std::vector<Stretch> cut(const DrivenPath& path, const StretchOptions& options) {
  const double wanted = options.length_m > 0.0 ? std::round(path.length_m() / options.length_m) : 1.0;
  const auto count = static_cast<std::size_t>(std::max(wanted, 1.0));
  std::vector<Stretch> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    out[i].from_m = path.length_m() * static_cast<double>(i) / static_cast<double>(count);
    out[i].to_m = path.length_m() * static_cast<double>(i + 1) / static_cast<double>(count);
  }
  return out;
}

std::size_t stretch_at(const std::vector<Stretch>& stretches, double place_m) {
  const auto behind =
      std::upper_bound(stretches.begin(), stretches.end(), place_m, [](double place, const Stretch& s) {
        return place < s.to_m;
      });
  return std::min(static_cast<std::size_t>(behind - stretches.begin()), stretches.size() - 1);
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

FrameSelection all_of(FrameSelection frames) {
  frames.held_out_every = 0;
  frames.held_out_last = 0.0;
  return frames;
}

Log log_of(const Log& log,
           const FrameSelection& frames,
           const DrivenPath& path,
           const Stretch& stretch,
           double overlap_m) {
  Log out = log;
  const HeldOutRule rule(log, frames);
  out.images = frames_of(log.images, rule, path, stretch, overlap_m);
  out.sweeps = frames_of(log.sweeps, rule, path, stretch, overlap_m);
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
