#include "optim/init/actor_tracks.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "host/core/base/interruption.hpp"
#include "host/core/base/parallel.hpp"

namespace simuli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr std::array<double, 12> kVoxel_m{0.8, 0.8, 0.8, 0.5, 0.5, 0.5, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3};
constexpr std::size_t kLeast = 6;  // returns of a voxel with a surface
constexpr double kSigma_m = 0.03;  // of a return from the surface
constexpr double kCauchy = 3.0;       // standard deviations
constexpr double kReturnsOfKey = 50;  // weight limit: errors of neighbouring returns are correlated
constexpr std::size_t kReturnsOfPart = 1024;  // returns summed by one core

/// The normal distribution of the returns in a voxel.
struct Surface {
  Vector3d mean = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();  // sum of outer products, later the inverse covariance
  std::size_t count = 0;
};

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Vector3d rotation_vector(const Eigen::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q);
  return turn.angle() * turn.axis();
}

/// Normal equations with 6 unknowns per key pose: (shift, turn), world axes.
class Equations {
 public:
  explicit Equations(std::size_t keys)
      : gradient_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * keys))) {}
  void add(std::size_t row_key, std::size_t column_key, const Matrix6& block) {
    blocks_.try_emplace({row_key, column_key}, Matrix6::Zero()).first->second += block;
  }
  void add(std::size_t key, const Vector6& gradient) {
    gradient_.segment<6>(static_cast<Eigen::Index>(6 * key)) += gradient;
  }
  [[nodiscard]] Eigen::VectorXd step() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [keys, block] : blocks_) {
      for (int k = 0; k < 36; ++k) {
        entries.emplace_back(static_cast<int>(6 * keys.first) + k / 6,
                             static_cast<int>(6 * keys.second) + k % 6,
                             block(k / 6, k % 6));
      }
    }
    Eigen::SparseMatrix<double> matrix(gradient_.size(), gradient_.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(-gradient_);
  }

 private:
  std::map<std::pair<std::size_t, std::size_t>, Matrix6> blocks_;
  Eigen::VectorXd gradient_;
};

/// Contributions of the returns between two key poses to the blocks of these poses.
struct KeySums {
  std::array<Matrix6, 3> square{Matrix6::Zero(), Matrix6::Zero(), Matrix6::Zero()};  // first, both, second
  std::array<Vector6, 2> gradient{Vector6::Zero(), Vector6::Zero()};
};

/// Adds the priors of labels and accelerations.
void add_prior(const Actor& actor, const TrackPrior& prior, Equations& equations) {
  Vector6 label, bend;
  label << Vector3d::Constant(1.0 / prior.label_m), Vector3d::Constant(1.0 / prior.label_rad);
  bend << Vector3d::Constant(1.0 / prior.acceleration_m_per_s2),
      Vector3d::Constant(1.0 / prior.turn_rad_per_s2);
  const Vector6 label2 = label.cwiseAbs2(), bend2 = bend.cwiseAbs2();
  const std::vector<KeyPose>& track = actor.track;
  for (std::size_t k = 0; k < track.size(); ++k) {
    Vector6 off;
    off << track[k].shift_m, track[k].turn_rad;
    equations.add(k, k, label2.asDiagonal());
    equations.add(k, label2.cwiseProduct(off));
  }
  for (std::size_t k = 1; k + 1 < track.size(); ++k) {
    const double before_s = track[k].time_s - track[k - 1].time_s,
                 after_s = track[k + 1].time_s - track[k].time_s;
    const double mean_s = 0.5 * (before_s + after_s);
    const Pose a = track[k - 1].corrected(), b = track[k].corrected(), c = track[k + 1].corrected();
    const std::array<double, 3> weight{
        1.0 / (before_s * mean_s), -(1.0 / before_s + 1.0 / after_s) / mean_s, 1.0 / (after_s * mean_s)};
    Vector6 rate;
    rate << (c.translation - b.translation) / (after_s * mean_s) -
                (b.translation - a.translation) / (before_s * mean_s),
        rotation_vector(c.rotation * b.rotation.conjugate()) / (after_s * mean_s) -
            rotation_vector(b.rotation * a.rotation.conjugate()) / (before_s * mean_s);
    for (std::size_t i = 0; i < 3; ++i) {
      equations.add(k - 1 + i, weight[i] * bend2.cwiseProduct(rate));
      for (std::size_t j = 0; j < 3; ++j) {
        equations.add(k - 1 + i, k - 1 + j, Matrix6((weight[i] * weight[j] * bend2).asDiagonal()));
      }
    }
  }
}

}  // namespace

Matrix3d surface_information(const Matrix3d& covariance, double sigma_m, double voxel_m) {
  constexpr double kFilled = 0.2;  // deviation relative to the voxel's side; a uniform distribution has 0.29
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(covariance);
  Vector3d information;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double variance = std::max(axes.eigenvalues()(k), 0.0);
    information(k) = std::sqrt(variance) > kFilled * voxel_m ? 0.0 : 1.0 / (variance + sigma_m * sigma_m);
  }
  return axes.eigenvectors() * information.asDiagonal() * axes.eigenvectors().transpose();
}

void register_track(Actor& actor, const std::vector<ActorReturn>& returns, const TrackPrior& prior) {
  std::vector<KeyPose>& track = actor.track;
  if (track.size() < 2 || returns.empty()) return;
  std::vector<double> heard(track.size(), 0.0);
  std::vector<KeyShare> between(returns.size());
  for (std::size_t i = 0; i < returns.size(); ++i) {
    between[i] = actor.key_share(returns[i].time_s);
    heard[between[i].key] += 1.0 - between[i].share;
    heard[between[i].key + 1] += between[i].share;
  }
  using Cell = std::array<int, 3>;
  std::vector<Pose> world_from_actor(returns.size());
  std::vector<Vector3d> p_actor(returns.size());
  std::vector<const Surface*> surface_of(returns.size());
  for (const double voxel_m : kVoxel_m) {
    Interruption::ask();
    std::vector<Pose> keys;
    for (const KeyPose& key : track) keys.push_back(key.corrected());
    parallel_each(
        returns.size(),
        [&](std::size_t i) {
          const auto& [key, share] = between[i];
          world_from_actor[i] = interpolate(keys[key], keys[key + 1], share);
          p_actor[i] = world_from_actor[i].inverse() * returns[i].p_world;
        },
        kReturnsOfPart);
    std::map<Cell, Surface> surfaces;
    for (std::size_t i = 0; i < returns.size(); ++i) {
      const Eigen::Vector3i c = (p_actor[i] / voxel_m).array().floor().cast<int>();
      Surface& surface = surfaces[{c.x(), c.y(), c.z()}];
      surface.mean += p_actor[i];
      surface.squares += p_actor[i] * p_actor[i].transpose();
      ++surface.count;
      surface_of[i] = &surface;
    }
    for (auto& [cell, s] : surfaces) {
      const auto count = static_cast<double>(s.count);
      s.mean /= count;
      const Matrix3d covariance = s.squares / count - s.mean * s.mean.transpose();
      s.squares = surface_information(covariance, kSigma_m, voxel_m);
    }

    const auto add = [&](std::size_t i, KeySums& sums) {
      const Surface& surface = *surface_of[i];
      if (surface.count < kLeast) return;
      const Vector3d off = p_actor[i] - surface.mean;
      const Vector3d pulled = surface.squares * off;
      const auto& [key, share] = between[i];
      const double heard_here = (1.0 - share) * heard[key] + share * heard[key + 1];
      const double weight =
          std::min(1.0, kReturnsOfKey / heard_here) / (1.0 + off.dot(pulled) / (kCauchy * kCauchy));
      // p_actor = R^T (p - c); a rotation w about c changes R to (1 + [w]) R.
      const Matrix3d actor_from_world = world_from_actor[i].rotation.conjugate().toRotationMatrix();
      Matrix36 slope;
      slope << -actor_from_world,
          actor_from_world * cross_matrix(returns[i].p_world - world_from_actor[i].translation);
      const Matrix36 weighted = weight * surface.squares * slope;
      const Matrix6 square = slope.transpose() * weighted;
      const Vector6 gradient = weight * (slope.transpose() * pulled);
      sums.square[0] += (1.0 - share) * (1.0 - share) * square;
      sums.square[1] += (1.0 - share) * share * square;
      sums.square[2] += share * share * square;
      sums.gradient[0] += (1.0 - share) * gradient;
      sums.gradient[1] += share * gradient;
    };
    // Sums parts of one size in order, so that the result does not depend on the number of cores.
    const std::size_t parts = (returns.size() + kReturnsOfPart - 1) / kReturnsOfPart;
    std::vector<std::map<std::size_t, KeySums>> of_parts(parts);
    parallel_each(
        parts,
        [&](std::size_t part) {
          const std::size_t last = std::min((part + 1) * kReturnsOfPart, returns.size());
          for (std::size_t i = part * kReturnsOfPart; i < last; ++i) add(i, of_parts[part][between[i].key]);
        },
        1);
    Equations equations(track.size());
    add_prior(actor, prior, equations);
    for (const auto& of_part : of_parts) {
      for (const auto& [key, sums] : of_part) {
        for (std::size_t a = 0; a < 2; ++a) {
          equations.add(key + a, sums.gradient[a]);
          for (std::size_t b = 0; b < 2; ++b) equations.add(key + a, key + b, sums.square[a + b]);
        }
      }
    }
    const Eigen::VectorXd step = equations.step();
    if (!step.allFinite()) return;
    for (std::size_t k = 0; k < track.size(); ++k) {
      const Vector6 by = step.segment<6>(static_cast<Eigen::Index>(6 * k));
      track[k].shift_m += by.head<3>();
      const Vector3d turn = by.tail<3>();
      const double angle = turn.norm();
      const Eigen::Quaterniond more(
          Eigen::AngleAxisd(angle, angle > 0.0 ? Vector3d(turn / angle) : Vector3d::UnitZ()));
      track[k].turn_rad = rotation_vector(more * track[k].corrected().rotation *
                                          track[k].world_from_actor.rotation.conjugate());
    }
  }
}

}  // namespace simuli
