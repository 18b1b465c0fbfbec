#include "host/device/render/levels/levels.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "host/core/scene/particle_order.hpp"

namespace simuli {
namespace {

constexpr int kLevels = 11;  // cell sizes from 1/16 m to 64 m
constexpr std::size_t kFewest = 3;  // smallest family that is merged
constexpr double kMostOpaque = 0.999;

double opacity_of(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

/// Mean projected area over all directions, approximately; in units of pi.
double mean_area(const Eigen::Vector3d& sigma) {
  return (sigma.x() * sigma.y() + sigma.y() * sigma.z() + sigma.z() * sigma.x()) / 3.0;
}

/// Whether sums of squares stay finite.
bool can_merge(const Eigen::Ref<const Eigen::VectorXf>& particle) {
  constexpr float kMost = 1e9F, kLogScale = 15.0F;
  return (particle.array().abs() < kMost).all() &&
         (particle.segment<3>(kLogScaleRow).array().abs() < kLogScale).all() &&
         particle.segment<4>(kRotationRow).squaredNorm() > 1e-12F;
}

float longest_axis(const Eigen::Ref<const Eigen::VectorXf>& particle) {
  return std::exp(particle.segment<3>(kLogScaleRow).maxCoeff());
}

Eigen::Matrix3d covariance_of(const Eigen::VectorXd& particle) {
  const Eigen::Vector4d q = particle.segment<4>(kRotationRow).normalized();
  const Eigen::Matrix3d axes = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix();
  const Eigen::Vector3d sigma = particle.segment<3>(kLogScaleRow).array().exp();
  return axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
}

void set_covariance(const Eigen::Matrix3d& covariance, Eigen::VectorXd& particle) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  const Eigen::Quaterniond q(axes);
  const double least = 1e-10 * solver.eigenvalues()(2);
  particle.segment<3>(kLogScaleRow) = 0.5 * solver.eigenvalues().array().max(least).log();
  particle.segment<4>(kRotationRow) << q.w(), q.x(), q.y(), q.z();
}

/// All particles, beginning with those of the set; one column each.
class Particles {
 public:
  explicit Particles(const GaussianSet& set)
      : rows_(set.params.cols()), values_(static_cast<std::size_t>(set.params.size())) {
    Eigen::Map<Eigen::MatrixXf>(values_.data(), rows_, set.size()) = set.params.transpose();
  }
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(values_.size()) / rows_; }
  void add(Eigen::Index count) { values_.resize(values_.size() + static_cast<std::size_t>(count * rows_)); }
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXf> all() const { return {values_.data(), rows_, size()}; }
  [[nodiscard]] Eigen::Map<Eigen::VectorXf> column(Eigen::Index i) {
    return {values_.data() + i * rows_, rows_};
  }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXf> operator[](Eigen::Index i) const {
    return {values_.data() + i * rows_, rows_};
  }

 private:
  Eigen::Index rows_;
  std::vector<float> values_;
};

/// Returns the particle that represents `members`.
Eigen::VectorXf merged(const Particles& all, std::span<const Eigen::Index> members) {
  std::vector<double> shadows;
  for (const Eigen::Index i : members) {
    const Eigen::Vector3d sigma = all[i].segment<3>(kLogScaleRow).cast<double>().array().exp();
    shadows.push_back(opacity_of(static_cast<double>(all[i](kOpacityRow))) * mean_area(sigma));
  }
  const double sum = std::accumulate(shadows.begin(), shadows.end(), 0.0);
  const auto weight = [&](std::size_t k) {
    return sum > 0.0 ? shadows[k] / sum : 1.0 / static_cast<double>(members.size());
  };
  Eigen::VectorXd one = Eigen::VectorXd::Zero(all[0].size());
  for (std::size_t k = 0; k < members.size(); ++k) one += weight(k) * all[members[k]].cast<double>();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Eigen::VectorXd particle = all[members[k]].cast<double>();
    const Eigen::Vector3d off = particle.segment<3>(kMeanRow) - one.segment<3>(kMeanRow);
    covariance += weight(k) * (covariance_of(particle) + off * off.transpose());
  }
  set_covariance(covariance, one);
  // Transmittance of all members, each spread over the merged particle's area.
  const double area = mean_area(one.segment<3>(kLogScaleRow).array().exp());
  double past = 1.0;
  for (const double shadow : shadows) past *= 1.0 - std::min(shadow / area, kMostOpaque);
  const double opacity = std::clamp(1.0 - past, 1e-6, kMostOpaque);
  one(kOpacityRow) = std::log(opacity / (1.0 - opacity));
  return one.cast<float>();
}

/// A particle that is not represented by another yet.
struct Node {
  Eigen::Index particle;
  float longest_m;  // longest axis; kNeverMerged: is never merged
};

/// Indices of particles that are merged into one.
struct Family {
  std::size_t begin, end;
};

class Builder {
 public:
  explicit Builder(const GaussianSet& set) : particles_(set), owner_(set.actor) {
    const auto count = static_cast<std::size_t>(set.size());
    owner_.resize(count, 0);
    from_m_.assign(count, 0.0F);
    until_m_.assign(count, kNeverMerged);
    code_.assign(count, 0);
    nodes_.reserve(count);
    for (const Eigen::Index i : coherent_order(set)) {
      const auto k = static_cast<std::size_t>(i);
      code_[k] = coherent_code(set.mean().row(i));
      nodes_.push_back({i, can_merge(particles_[i]) ? longest_axis(particles_[i]) : kNeverMerged});
    }
  }

  /// Merges within cells of 2^level / 16 m.
  void merge(int level) {
    const float largest_m = std::ldexp(0.5F / kCoherentCellsPerMetre, level);
    const auto cell = [&](const Node& node) {
      const auto k = static_cast<std::size_t>(node.particle);
      return std::pair(owner_[k], code_[k] >> static_cast<unsigned>(3 * level));
    };
    std::vector<Eigen::Index> members;
    std::vector<Family> families;
    std::vector<Node> next;
    for (std::size_t begin = 0, end = 0; begin < nodes_.size(); begin = end) {
      const std::size_t first = members.size();
      for (end = begin; end < nodes_.size() && cell(nodes_[end]) == cell(nodes_[begin]); ++end) {
        if (nodes_[end].longest_m <= largest_m) members.push_back(nodes_[end].particle);
      }
      const bool merges = members.size() - first >= kFewest;
      if (!merges) members.resize(first);
      for (std::size_t i = begin; i < end; ++i) {
        if (!merges || nodes_[i].longest_m > largest_m) next.push_back(nodes_[i]);
      }
      if (!merges) continue;
      next.push_back({particles_.size() + static_cast<Eigen::Index>(families.size()), 0.0F});
      families.push_back({first, members.size()});
    }
    add(families, members);
    for (Node& node : next) {
      if (node.longest_m == 0.0F) node.longest_m = longest_axis(particles_[node.particle]);
    }
    nodes_ = std::move(next);
  }

  [[nodiscard]] DetailLevels levels(const GaussianSet& of) && {
    DetailLevels out{GaussianSet(of.kind, of.sh_degree, 0), std::move(from_m_), std::move(until_m_)};
    out.set.params = particles_.all().transpose();
    if (!of.actor.empty()) out.set.actor = std::move(owner_);
    return out;
  }

 private:
  void add(const std::vector<Family>& families, const std::vector<Eigen::Index>& members) {
    const Eigen::Index first = particles_.size();
    particles_.add(static_cast<Eigen::Index>(families.size()));
    parallel_each(
        families.size(),
        [&](std::size_t k) {
          const std::span whole(members.data() + families[k].begin, members.data() + families[k].end);
          particles_.column(first + static_cast<Eigen::Index>(k)) = merged(particles_, whole);
        },
        256);
    for (std::size_t k = 0; k < families.size(); ++k) {
      const std::span whole(members.data() + families[k].begin, members.data() + families[k].end);
      // A merged particle appears only after all its members.
      float from_m = longest_axis(particles_[first + static_cast<Eigen::Index>(k)]);
      for (const Eigen::Index i : whole) {
        from_m = std::max(from_m, kDetailFade * from_m_[static_cast<std::size_t>(i)]);
      }
      for (const Eigen::Index i : whole) until_m_[static_cast<std::size_t>(i)] = from_m;
      const auto any = static_cast<std::size_t>(whole.front());
      from_m_.push_back(from_m);
      until_m_.push_back(kNeverMerged);
      owner_.push_back(owner_[any]);
      code_.push_back(code_[any]);
    }
  }

  Particles particles_;
  std::vector<std::uint32_t> owner_;
  std::vector<float> from_m_, until_m_;
  std::vector<std::uint64_t> code_;
  std::vector<Node> nodes_;  // sorted spatially
};

}  // namespace

DetailLevels detail_levels(const GaussianSet& set) {
  Builder builder(set);
  for (int level = 0; level < kLevels; ++level) builder.merge(level);
  return std::move(builder).levels(set);
}

}  // namespace simuli
