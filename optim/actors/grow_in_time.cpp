// Follows a body through sweeps where it stands, or where too few returns show it for a cluster.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>

#include "optim/actors/body_track.hpp"
#include "optim/init/actor_tracks.hpp"

namespace simuli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kVoxel_m = 0.5;
constexpr std::size_t kLeastOfVoxel = 5;
constexpr double kSigma_m = 0.05;  // of a return from the surface
constexpr double kCauchy = 3.0;         // standard deviations
constexpr double kReturnsHeard = 60.0;  // weight limit in returns: errors of neighbours are correlated
constexpr double kAcceleration = 4.0;  // m/s^2, standard deviation of the prediction
constexpr double kTurn_rad = 0.02;  // standard deviation of the predicted heading
constexpr int kRounds = 12;
constexpr double kMargin_m = 0.3;  // around the box
constexpr std::size_t kLeastReturns = 10;
constexpr double kLeastOfLast = 0.2;  // share of the returns of the previous sweeps
constexpr double kLeastExplained = 0.5;  // share of the returns explained by the model
constexpr double kExplained_m = 0.25;
constexpr double kMostThrough = 0.25;  // share of a sweep's see-through votes on the body
constexpr std::size_t kMostMissed = 3;  // sweeps without the body before tracking ends
constexpr std::size_t kVoters = 400;

/// Surface of the body: a normal distribution per voxel.
class Surface {
 public:
  void add(const Vector3d& p) {
    Voxel& v = voxels_[cell_of(p)];
    v.sum += p;
    v.squares += p * p.transpose();
    ++v.count;
  }
  struct Normal {
    Vector3d mean;
    Matrix3d inverse;  // of the covariance
  };
  [[nodiscard]] std::optional<Normal> at(const Vector3d& p) const {
    const auto found = voxels_.find(cell_of(p));
    if (found == voxels_.end() || found->second.count < kLeastOfVoxel) return std::nullopt;
    const auto count = static_cast<double>(found->second.count);
    const Vector3d mean = found->second.sum / count;
    const Matrix3d covariance = found->second.squares / count - mean * mean.transpose();
    return Normal{mean, surface_information(covariance, kSigma_m, kVoxel_m)};
  }

 private:
  using Cell = std::array<int, 3>;
  struct Voxel {
    Vector3d sum = Vector3d::Zero();
    Matrix3d squares = Matrix3d::Zero();
    std::size_t count = 0;
  };
  static Cell cell_of(const Vector3d& p) {
    const Eigen::Vector3i c = (p / kVoxel_m).array().floor().cast<int>();
    return {c.x(), c.y(), c.z()};
  }
  std::map<Cell, Voxel> voxels_;
};

/// Tracking in one direction of time.
class Follower {
 public:
  Follower(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken)
      : series_(series), track_(track), taken_(taken) {
    for (std::size_t k = 0; k < track.keys(); ++k) {
      const std::vector<BodyReturn> here = returns_of(series, track, k, track.box, taken);
      counts_.push_back(here.size());
      for (const BodyReturn& r : here) surface_.add(r.p_body);
    }
    box_ = track.box;
    box_.min() -= Vector3d(kMargin_m, kMargin_m, 0.0);
    box_.max() += Vector3d::Constant(kMargin_m);
  }

  void forward() {
    std::size_t missed = 0;
    for (std::size_t s = track_.sweeps.back() + 1; s < series_.sweeps.size() && missed <= kMostMissed; ++s)
      missed = follow(s, true) ? 0 : missed + 1;
  }
  void backward() {
    std::size_t missed = 0;
    for (std::size_t s = track_.sweeps.front(); s-- > 0 && missed <= kMostMissed;)
      missed = follow(s, false) ? 0 : missed + 1;
  }

 private:
  /// Predicted pose of the body at a time, from its last keys.
  [[nodiscard]] Pose predicted(double time_s, bool forward) const {
    const std::vector<KeyPose>& keys = track_.actor.track;
    const std::size_t reach = std::min<std::size_t>(3, keys.size() - 1);
    const KeyPose& end = forward ? keys.back() : keys.front();
    const KeyPose& inner = forward ? keys[keys.size() - 1 - reach] : keys[reach];
    const double share = (time_s - end.time_s) / (end.time_s - inner.time_s);
    const Pose &a = inner.world_from_actor, &b = end.world_from_actor;
    Pose out = b;
    out.translation += share * (b.translation - a.translation);
    const Eigen::AngleAxisd turn(b.rotation * a.rotation.conjugate());
    out.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(share * turn.angle(), turn.axis())) * b.rotation;
    if (const auto ground = series_.ground.height_m(out.translation.x(), out.translation.y()))
      out.translation.z() = *ground + track_.above_ground_m;
    return out;
  }

  /// Adds a key for the sweep if the body is found there.
  bool follow(std::size_t sweep, bool forward) {
    std::vector<KeyPose>& keys = track_.actor.track;
    KeyPose key;
    const KeyPose& end = forward ? keys.back() : keys.front();
    key.time_s = series_.looks_at_s(sweep, predicted(series_.sweeps[sweep].middle_s(), forward).translation);
    if (forward ? !(key.time_s > end.time_s) : !(key.time_s < end.time_s)) return false;
    const double gap_s = std::abs(key.time_s - end.time_s);
    key.world_from_actor = predicted(key.time_s, forward);
    const Pose expected = key.world_from_actor;
    const std::size_t at = forward ? keys.size() : 0;
    keys.insert(keys.begin() + static_cast<std::ptrdiff_t>(at), key);
    track_.sweeps.insert(track_.sweeps.begin() + static_cast<std::ptrdiff_t>(at), sweep);
    counts_.insert(counts_.begin() + static_cast<std::ptrdiff_t>(at), 0);
    for (int round = 0; round < kRounds; ++round) {
      if (!step(at, expected, gap_s)) break;
    }
    const std::vector<BodyReturn> here = returns_of(series_, track_, at, box_, taken_);
    if (!is_found(at, here, forward)) {
      keys.erase(keys.begin() + static_cast<std::ptrdiff_t>(at));
      track_.sweeps.erase(track_.sweeps.begin() + static_cast<std::ptrdiff_t>(at));
      counts_.erase(counts_.begin() + static_cast<std::ptrdiff_t>(at));
      return false;
    }
    counts_[at] = here.size();
    for (const BodyReturn& r : here) surface_.add(r.p_body);
    return true;
  }

  /// One Gauss-Newton step of x, y and heading; false without equations.
  bool step(std::size_t at, const Pose& expected, double gap_s) {
    const std::vector<BodyReturn> here = returns_of(series_, track_, at, box_, taken_);
    if (here.size() < kLeastReturns) return false;
    Pose& pose = track_.actor.track[at].world_from_actor;
    const Matrix3d body_from_scene = pose.rotation.conjugate().toRotationMatrix();
    Matrix3d square = Matrix3d::Zero();
    Vector3d gradient = Vector3d::Zero();
    for (const BodyReturn& r : here) {
      const auto normal = surface_.at(r.p_body);
      if (!normal) continue;
      const Vector3d off = r.p_body - normal->mean;
      const Vector3d pulled = normal->inverse * off;
      const double weight = 1.0 / (1.0 + off.dot(pulled) / (kCauchy * kCauchy));
      // Derivative of p_body = R^T (p - c) by a shift of c in x and y, and by a rotation about z through c.
      const Vector3d from_centre = series_.sweeps[track_.sweeps[at]].position(r.point) - pose.translation;
      Matrix3d slope;
      slope.col(0) = -body_from_scene.col(0);
      slope.col(1) = -body_from_scene.col(1);
      slope.col(2) = -body_from_scene * Vector3d::UnitZ().cross(from_centre);
      square += weight * slope.transpose() * normal->inverse * slope;
      gradient += weight * slope.transpose() * pulled;
    }
    const double share = std::min(1.0, kReturnsHeard / static_cast<double>(here.size()));
    square *= share;
    gradient *= share;
    const double sigma_m = std::max(0.02, 0.5 * kAcceleration * gap_s * gap_s);
    const Vector3d belief(
        1.0 / (sigma_m * sigma_m), 1.0 / (sigma_m * sigma_m), 1.0 / (kTurn_rad * kTurn_rad));
    const Eigen::AngleAxisd turned(pose.rotation * expected.rotation.conjugate());
    Vector3d off = pose.translation - expected.translation;
    off.z() = turned.angle() * turned.axis().z();
    square += belief.asDiagonal();
    gradient += belief.cwiseProduct(off);
    const Vector3d by = -square.ldlt().solve(gradient);
    if (!by.allFinite()) return false;
    pose.translation.head<2>() += by.head<2>();
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(by.z(), Vector3d::UnitZ())) * pose.rotation;
    return by.norm() > 1e-4;
  }

  [[nodiscard]] bool is_found(std::size_t at, const std::vector<BodyReturn>& here, bool forward) const {
    double last = 0.0;
    std::size_t summed = 0;
    for (std::size_t k = 1; k <= 3 && k < counts_.size(); ++k, ++summed)
      last += static_cast<double>(counts_[forward ? at - k : at + k]);
    const double needed = kLeastOfLast * last / static_cast<double>(std::max<std::size_t>(1, summed));
    if (here.size() < kLeastReturns || static_cast<double>(here.size()) < needed) return false;
    std::size_t explained = 0;
    for (const BodyReturn& r : here) {
      const auto normal = surface_.at(r.p_body);
      if (!normal) continue;
      const Vector3d off = r.p_body - normal->mean;
      // Distance along the surface's normal: off^T C^-1 off <= (kExplained / sigma)^2 for thin surfaces.
      explained += off.dot(normal->inverse * off) <= std::pow(kExplained_m / kSigma_m, 2) ? 1U : 0U;
    }
    if (static_cast<double>(explained) < kLeastExplained * static_cast<double>(here.size())) return false;
    return is_not_looked_through(at, forward);
  }

  /// Tests the body, as the neighbouring sweeps saw it, by the votes of this sweep.
  [[nodiscard]] bool is_not_looked_through(std::size_t at, bool forward) const {
    std::vector<BodyReturn> known;
    for (std::size_t k = 1; k <= 3 && k < track_.keys(); ++k) {
      const auto of = returns_of(series_, track_, forward ? at - k : at + k, track_.box, taken_);
      known.insert(known.end(), of.begin(), of.end());
    }
    const std::size_t stride = known.size() / kVoters + 1;
    PointSet points;
    points.position.resize(3, static_cast<Eigen::Index>((known.size() + stride - 1) / stride));
    points.intensity.assign((known.size() + stride - 1) / stride, 0.0F);
    const Pose& pose = track_.actor.track[at].world_from_actor;
    for (std::size_t i = 0, n = 0; i < known.size(); i += stride, ++n)
      points.position.col(static_cast<Eigen::Index>(n)) = (pose * known[i].p_body).cast<float>();
    std::vector<PointVotes> votes(points.size());
    series_.vote(track_.sweeps[at], points, votes);
    double through = 0.0, there = 0.0;
    for (const PointVotes& v : votes) {
      through += v.through;
      there += v.there;
    }
    return through <= kMostThrough * (through + there);
  }

  const SweepSeries& series_;
  BodyTrack& track_;
  const TakenReturns& taken_;
  Surface surface_;
  std::vector<std::size_t> counts_;  // of each key
  Eigen::AlignedBox3d box_;
};

}  // namespace

void grow_in_time(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken) {
  if (track.keys() < 2) return;
  Follower follower(series, track, taken);
  follower.forward();
  follower.backward();
}

}  // namespace simuli
