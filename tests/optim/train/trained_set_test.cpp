// Tests that all data of a particle move with it.
#include "optim/train/trained_set.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "bench/particles/particle_street.hpp"
#include "host/core/scene/particle_order.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr Eigen::Index kCount = 333;

/// Particles in random order; all data of particle i contain i and the row.
struct Numbered {
  Numbered() : trained(test::device(), set(), {}, {}) {
    const std::size_t stride = trained.particles.stride;
    for (RealBuffer* const buffer : {&trained.adam.first_moment(), &trained.adam.second_moment()}) {
      std::vector<float> values(buffer->count(), 0.0F);
      for (std::size_t at = 0; at < values.size(); ++at) {
        if (at % stride < kCount) values[at] = static_cast<float>(at % stride + 1000 * (at / stride));
      }
      buffer->assign(values);
    }
    std::vector<float> errors(kCount);
    for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = static_cast<float>(i);
    trained.error.assign(errors);
  }
  static GaussianSet set() {
    GaussianSet out = street_particles(SetKind::kLidar, 1, kCount, 4, StreetOrder::kShuffled);
    for (Eigen::Index i = 0; i < kCount; ++i) out.actor.push_back(i % 3 == 0 ? 1 : 0);
    return out;
  }
  /// Expects that all data are in the order of `order`.
  void expect(const std::vector<Eigen::Index>& order) {
    const GaussianSet found = trained.particles.download(), expected = subset(set(), order);
    EXPECT_EQ(found.params, expected.params);
    EXPECT_EQ(found.actor, expected.actor);
    const std::size_t stride = trained.particles.stride;
    for (RealBuffer* const buffer : {&trained.adam.first_moment(), &trained.adam.second_moment()}) {
      const std::vector<float> values = buffer->download_float();
      ASSERT_EQ(values.size(), stride * static_cast<std::size_t>(found.params.cols()));
      for (std::size_t row = 0; row * stride < values.size(); ++row) {
        for (std::size_t i = 0; i < order.size(); ++i) {
          ASSERT_EQ(values[row * stride + i],
                    static_cast<float>(order[i]) + 1000.0F * static_cast<float>(row));
        }
      }
    }
    const std::vector<float> errors = trained.error.download_float();
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(errors[i], static_cast<float>(order[i]));
  }
  TrainedSet trained;
};

TEST(TrainedSet, IsPutInOrderWithAllThatBelongsToIt) {
  Numbered numbered;
  const std::vector<Eigen::Index> order = numbered.trained.put_in_order();
  EXPECT_EQ(order, coherent_order(Numbered::set()));
  EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
  numbered.expect(order);
  const std::vector<Eigen::Index> again = numbered.trained.put_in_order();
  EXPECT_TRUE(std::is_sorted(again.begin(), again.end()));
  numbered.expect(order);
}

TEST(TrainedSet, KeepsWhatBelongsToThoseThatStay) {
  Numbered numbered;
  const std::vector<Eigen::Index> kept = {332, 5, 17, 18};
  numbered.trained.keep(kept);
  numbered.expect(kept);
}

}  // namespace
}  // namespace simuli
