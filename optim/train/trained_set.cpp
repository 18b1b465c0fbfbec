#include "optim/train/trained_set.hpp"

#include <algorithm>

#include "host/core/scene/particle_order.hpp"

namespace simuli {
namespace {

/// Copies the columns `kept` of each row of length `stride` to rows of length new_stride, padded with zeros.
void keep_columns(RealBuffer& rows,
                  std::size_t stride,
                  std::size_t new_stride,
                  const std::vector<Eigen::Index>& kept) {
  const std::vector<float> before = rows.download_float();
  std::vector<float> after(before.size() / stride * new_stride, 0.0F);
  for (std::size_t row = 0; row * stride < before.size(); ++row) {
    for (std::size_t i = 0; i < kept.size(); ++i) {
      after[row * new_stride + i] = before[row * stride + static_cast<std::size_t>(kept[i])];
    }
  }
  rows.assign(after);
}

}  // namespace

TrainedSet::TrainedSet(const Device& device,
                       const GaussianSet& set,
                       const PoseRates& pose_rates,
                       bool learns_shapes)
    : particles(device, set, Precision::kFloat),
      grads(device, "gradients", Precision::kFloat, particles.params.count()),
      error(device, "reconstruction errors", Precision::kFloat, particles.count),
      adam(device, particles),
      poses(pose_rates),
      shapes(learns_shapes) {
  grads.fill(0.0);
  error.fill(0.0);
}

void TrainedSet::fit_gradients() {
  if (grads.count() == particles.params.count()) return;
  grads.reserve(particles.params.count());
  grads.fill(0.0);  // kernels write no gradient to the padding after the last particle
}

void TrainedSet::keep(const std::vector<Eigen::Index>& kept) { keep(particles.download(), kept); }

void TrainedSet::keep(const GaussianSet& set, const std::vector<Eigen::Index>& kept) {
  const std::size_t count = particles.count, stride = particles.stride;
  if (kept.size() == count && std::is_sorted(kept.begin(), kept.end())) return;
  particles.upload(subset(set, kept));
  for (RealBuffer* const moment : {&adam.first_moment(), &adam.second_moment()}) {
    keep_columns(*moment, stride, particles.stride, kept);
  }
  keep_columns(error, count, kept.size(), kept);
  fit_gradients();
}

std::vector<Eigen::Index> TrainedSet::put_in_order() {
  const GaussianSet set = particles.download();
  std::vector<Eigen::Index> order = coherent_order(set);
  keep(set, order);
  return order;
}

void TrainedSet::freeze_colours(const std::vector<Eigen::Index>& of) {
  constexpr float kHeld = 1e30F;  // a second moment so large that gradients have no effect for 60 000 steps
  RealBuffer& moments = adam.second_moment();
  std::vector<float> rows = moments.download_float();
  for (std::size_t first = kShRow * particles.stride; first < rows.size(); first += particles.stride) {
    for (const Eigen::Index i : of) rows[first + static_cast<std::size_t>(i)] = kHeld;
  }
  moments.assign(rows);
}

void TrainedSet::add_state(StateList& list, const std::string& name) {
  list.add(name + "/count", particles.count);
  list.add(name + "/stride", particles.stride);
  list.add(name + "/parameters", particles.params);
  list.add(name + "/actors", particles.actor_of);
  list.add(name + "/first_moment", adam.first_moment());
  list.add(name + "/second_moment", adam.second_moment());
  list.add(name + "/steps", adam.iteration());
  list.add(name + "/rejections", adam.rejections());
  list.add(name + "/errors", error);
}

}  // namespace simuli
