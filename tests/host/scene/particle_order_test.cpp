#include "host/core/scene/particle_order.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "bench/particles/particle_street.hpp"

namespace simuli {
namespace particle_order_test {

/// Returns particle i at places[i] with opacity i.
GaussianSet particles_at(const std::vector<Eigen::Vector3f>& places) {
  GaussianSet set(SetKind::kCamera, 0, static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    set.mean().row(static_cast<Eigen::Index>(i)) = places[i];
    set.opacity_logit()(static_cast<Eigen::Index>(i)) = static_cast<float>(i);
  }
  return set;
}

using Order = std::vector<Eigen::Index>;

TEST(ParticleOrder, RunsAlongTheCurve) {
  // The eight corners of a cube of two cells, drawn backwards: x changes first, z last.
  std::vector<Eigen::Vector3f> corners;
  for (int corner = 7; corner >= 0; --corner) {
    const Eigen::Vector3i cell(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    corners.emplace_back(0.1F * cell.cast<float>());
  }
  EXPECT_EQ(coherent_order(particles_at(corners)), (Order{7, 6, 5, 4, 3, 2, 1, 0}));
}

TEST(ParticleOrder, KeepsWhatIsInOneCell) {
  const GaussianSet set = particles_at({{5.0F, 0, 0}, {0.03F, 0, 0}, {0.01F, 0, 0}, {0.02F, 0, 0}});
  EXPECT_EQ(coherent_order(set), (Order{1, 2, 3, 0}));
}

TEST(ParticleOrder, PutsActorsBehindTheBackground) {
  GaussianSet set = particles_at({{0, 0, 0}, {9.0F, 0, 0}, {1.0F, 0, 0}, {0, 0, 0}});
  set.actor = {2, 0, 1, 1};
  EXPECT_EQ(coherent_order(set), (Order{1, 3, 2, 0}));
  const GaussianSet ordered = in_coherent_order(set);
  EXPECT_EQ(ordered.actor, (std::vector<std::uint32_t>{0, 1, 1, 2}));
  EXPECT_EQ(ordered.opacity_logit()(1), 3.0F);
}

TEST(ParticleOrder, TakesAnyPlace) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const GaussianSet set = particles_at({{kInfinity, kInfinity, kInfinity},
                                        {0, 0, 0},
                                        {kNan, kNan, kNan},
                                        {1e30F, 1e30F, 1e30F},
                                        {-1e30F, 0, 0}});
  Order order = coherent_order(set);
  EXPECT_EQ(order.front(), 2);
  EXPECT_EQ(order.back(), 3);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, (Order{0, 1, 2, 3, 4}));
}

TEST(ParticleOrder, LeavesWhatIsInOrder) {
  const GaussianSet street = street_particles(SetKind::kLidar, 0, 5000, 3);
  const GaussianSet again = in_coherent_order(street);
  EXPECT_EQ(again.params, street.params);
  EXPECT_EQ(in_coherent_order(GaussianSet{}).size(), 0);
}

TEST(ParticleOrder, BringsNeighboursTogether) {
  const auto step_m = [](StreetOrder order) {
    const GaussianSet street = street_particles(SetKind::kCamera, 0, 20000, 3, order);
    double sum = 0.0;
    for (Eigen::Index i = 1; i < street.size(); ++i) {
      sum += (street.mean().row(i) - street.mean().row(i - 1)).norm();
    }
    return sum / static_cast<double>(street.size() - 1);
  };
  EXPECT_LT(step_m(StreetOrder::kCoherent), 0.02 * step_m(StreetOrder::kShuffled));
}

TEST(ParticleOrder, TakesASubset) {
  GaussianSet set = particles_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  set.actor = {0, 1, 2};
  const GaussianSet some = subset(set, {2, 0});
  EXPECT_EQ(some.size(), 2);
  EXPECT_EQ(some.mean()(0, 0), 2.0F);
  EXPECT_EQ(some.actor, (std::vector<std::uint32_t>{2, 0}));
}

}  // namespace particle_order_test
}  // namespace simuli
