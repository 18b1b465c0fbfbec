// Tests sums of shards: one tree, independent of the distribution of its nodes.
#include "host/device/render/train/shard_sum.hpp"

#include <cmath>
#include <deque>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <vector>

#include "host/core/base/error.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace shard_sum_test {

constexpr std::uint32_t kCulled = 0xffffffffU;

struct Shard {
  std::vector<std::uint32_t> keys, columns;
  std::vector<float> grads;  // [rows][stride], with values also for invisible particles
};

Shard shard_of(std::size_t particles, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Shard shard;
  for (std::uint32_t i = 0; i < particles; ++i) {
    const bool is_shown = random() % 3 != 0;
    shard.keys.push_back(is_shown ? static_cast<std::uint32_t>(random() % 1000) : kCulled);
    if (is_shown) shard.columns.push_back(i);
  }
  // Values of different magnitudes, so that the order of a sum matters.
  for (std::size_t i = 0; i < count; ++i) {
    shard.grads.push_back(normal(random) * std::pow(10.0F, static_cast<float>(random() % 9) - 4.0F));
  }
  return shard;
}

class ShardSumTest : public testing::Test {
 protected:
  const Device& device = test::device();
  const ParticleBuffers particles{
      device, test::set_for(test::kLidarMoving, {.count = 1037, .scale_max = 3.0}, 12), Precision::kFloat};
  const std::size_t stride = particles.stride, rows = particles.params.count() / particles.stride;
  std::vector<Shard> shards;
  RealBuffer buffer(const std::vector<float>& values) const {
    RealBuffer out(device, "values", Precision::kFloat, values.size());
    out.upload(std::span<const float>(values));
    return out;
  }
  RealBuffer errors_of(std::size_t s) const {  // [stride]: the first row of its gradients
    const auto begin = shards[s].grads.begin();
    return buffer({begin, begin + static_cast<std::ptrdiff_t>(stride)});
  }
  struct Found {
    std::vector<float> sums, errors;  // [rows][stride], [particles]
    std::vector<std::uint32_t> keys;
    std::size_t nodes = 0, places = 0;  // sent; of the device
  };
  /// Adds shards [begin, end) with `stage`.
  void add(ShardSum& stage, std::size_t begin, std::size_t end, double share) {
    stage.start(particles, true);
    for (std::size_t s = begin; s < end; ++s) {
      stage.fresh_errors().copy_from(errors_of(s));
      stage.add(s, Buffer<std::uint32_t>(device, "keys", shards[s].keys), buffer(shards[s].grads), share);
    }
  }
  /// Returns the result of rank `rank` of `ranks`, which receives the packed sums of the others.
  Found total(std::size_t ranks, std::size_t rank = 0, double share = 1.0 / 3.0) {
    const auto begin = [&](std::size_t r) { return r * shards.size() / ranks; };
    Found found;
    std::deque<std::vector<std::uint32_t>> columns;
    std::deque<std::vector<float>> values;
    std::vector<ShardSum::Packed> others;
    for (std::size_t r = 0; r < ranks; ++r) {
      if (r == rank) continue;
      ShardSum stage(device, Precision::kFloat);
      add(stage, begin(r), begin(r + 1), share);
      for (std::size_t node = 0; node < stage.nodes(); ++node) {
        ShardSum::Packed packed = stage.shards_of(node);
        packed.columns = columns.emplace_back(stage.columns_of(node));
        auto& target = values.emplace_back(stage.rows() * packed.columns.size());
        stage.pack(node, packed.columns, target);
        packed.values = target;
        others.push_back(packed);
      }
    }
    ShardSum own(device, Precision::kFloat);
    add(own, begin(rank), begin(rank + 1), share);
    found.nodes = others.size();
    own.total(others);
    found.places = own.places();
    RealBuffer errors = buffer(std::vector<float>(particles.count, 0.5F));
    own.add_errors(errors);
    found.errors = errors.download_float();
    found.keys = own.keys().download();
    found.sums = own.sums().download_float();
    found.sums.resize(rows * stride);
    // Values of invisible particles are never set.
    for (std::size_t i = 0; i < found.sums.size(); ++i) {
      const std::size_t column = i % stride;
      if (column >= particles.count || found.keys[column] == kCulled) found.sums[i] = 0.0F;
    }
    return found;
  }
  void make(std::size_t count) {
    shards.clear();
    for (unsigned s = 0; s < count; ++s) shards.push_back(shard_of(particles.count, rows * stride, s));
  }
  /// Returns the tree over [first, first + size) on the host; no value if no shard contains the particle.
  std::optional<float> expected(
      std::size_t first, std::size_t end, std::size_t row, std::size_t i, float share) {
    if (first >= shards.size()) return {};
    if (end - first == 1) {
      if (shards[first].keys[i] == kCulled) return {};
      return share * shards[first].grads[row * stride + i];
    }
    const std::size_t middle = first + (end - first) / 2;
    const auto left = expected(first, middle, row, i, share), right = expected(middle, end, row, i, share);
    if (left && right) return *left + *right;
    return left ? left : right;
  }
};

TEST_F(ShardSumTest, IsThatOfABinaryTree) {
  // If the number is not a power of two: the next larger tree without the missing leaves.
  for (const std::size_t count : {1U, 2U, 3U, 4U, 6U, 7U}) {
    make(count);
    const Found found = total(1);
    const auto share = static_cast<float>(1.0 / 3.0);
    std::size_t shown = 0;
    for (std::size_t i = 0; i < particles.count; ++i) {
      for (std::size_t row = 0; row < rows; ++row) {
        const auto wanted = expected(0, 8, row, i, share);
        ASSERT_EQ(found.keys[i], wanted ? 0U : kCulled) << i;
        if (wanted) {
          ASSERT_EQ(found.sums[row * stride + i], *wanted) << count << ": " << row << " " << i;
        }
        shown += wanted ? 1U : 0U;
      }
      const auto error = expected(0, 8, 0, i, 1.0F);
      ASSERT_EQ(found.errors[i], error ? 0.5F + *error : 0.5F) << i;
    }
    EXPECT_GT(shown, rows * particles.count / 2);
  }
}

TEST_F(ShardSumTest, HasTheSameBitsHoweverItIsShared) {
  for (const std::size_t count : {2U, 4U, 5U, 8U}) {
    make(count);
    const Found alone = total(1);
    for (std::size_t ranks = 2; ranks <= count; ++ranks) {
      for (std::size_t rank = 0; rank < ranks; ++rank) {
        const Found found = total(ranks, rank);
        ASSERT_TRUE(found.sums == alone.sums) << count << " shards, rank " << rank << " of " << ranks;
        ASSERT_TRUE(found.errors == alone.errors);
        ASSERT_TRUE(found.keys == alone.keys);
      }
    }
    std::swap(shards.front(), shards.back());
    if (count > 2) {
      EXPECT_FALSE(total(1).sums == alone.sums);  // the order matters
    }
  }
}

TEST_F(ShardSumTest, WholeNodesAreSent) {
  make(8);
  EXPECT_EQ(total(2).nodes, 1U);
  EXPECT_EQ(total(4).nodes, 3U);
  EXPECT_EQ(total(3).nodes, 4U);  // [2, 4), [4, 5) and [5, 6), [6, 8)
}

TEST_F(ShardSumTest, TakesNoMorePlacesThanAreTold) {
  for (std::size_t count = 2; count <= 9; ++count) {
    make(count);
    for (std::size_t ranks = 1; ranks <= count; ++ranks) {
      for (std::size_t rank = 0; rank < ranks; ++rank) {
        ASSERT_LE(total(ranks, rank).places, ShardSum::most_nodes(count))
            << count << ": " << rank << " of " << ranks;
      }
    }
  }
}

TEST_F(ShardSumTest, WholeMatricesAreAddedToo) {
  make(1);
  const std::vector<float> from(shards[0].grads.begin(), shards[0].grads.begin() + 1000);
  ShardSum stage(device, Precision::kFloat);
  RealBuffer sum = buffer(std::vector<float>(from.size(), 2.0F));
  stage.add_all(from, 0.5, sum);
  const std::vector<float> all = sum.download_float();
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], std::fma(0.5F, from[i], 2.0F)) << i;
}

TEST_F(ShardSumTest, OthersAreRefused) {
  make(2);
  ShardSum stage(device, Precision::kFloat);
  stage.start(particles, false);
  const Buffer<std::uint32_t> keys(device, "keys", shards[0].keys);
  EXPECT_THROW(stage.add(0, keys, buffer(std::vector<float>(3)), 1.0), Error);
  const auto refused = [&](const ShardSum::Packed& other) {
    ShardSum own(device, Precision::kFloat);
    own.start(particles, false);
    own.add(0, keys, buffer(shards[0].grads), 1.0);
    EXPECT_THROW(own.total({&other, 1}), Error);
  };
  const std::vector<std::uint32_t> first{0}, beyond{particles.count};
  const std::vector<float> values(rows), fewer(rows - 1);
  refused({0, 1, first, values});  // already present
  refused({2, 1, first, values});  // one shard is missing
  refused({1, 1, beyond, values});
  refused({1, 1, first, fewer});
}

}  // namespace shard_sum_test
}  // namespace simuli
