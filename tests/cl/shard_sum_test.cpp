// Sums of shards: what stands in a matrix and what came packed are added alike, in the order of the calls.
#include "host/render/train/shard_sum.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "host/base/error.hpp"
#include "tests/cl/support.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kCulled = 0xffffffffU;

struct Shard {
  std::vector<std::uint32_t> keys, columns;
  std::vector<float> grads;  // [rows][stride], numbers also where nothing is shown
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
  // Of many sizes, so that the order of a sum shows.
  for (std::size_t i = 0; i < count; ++i) {
    shard.grads.push_back(normal(random) * std::pow(10.0F, static_cast<float>(random() % 9) - 4.0F));
  }
  return shard;
}

class ShardSumTest : public testing::Test {
 protected:
  const Device device = Device::best();
  const ParticleBuffers particles{
      device, test::set_for(test::kLidarMoving, {.count = 1037, .scale_max = 3.0}, 12), Precision::kFloat};
  const std::size_t stride = particles.stride, rows = particles.params.count() / particles.stride;
  std::vector<Shard> shards;
  void SetUp() override {
    for (unsigned s = 0; s < 3; ++s) shards.push_back(shard_of(particles.count, rows * stride, s));
  }
  std::vector<float> sum(const std::vector<std::size_t>& order, bool packed, double share = 1.0 / 3.0) {
    ShardSum stage(device, Precision::kFloat), other(device, Precision::kFloat);
    stage.start(particles);
    other.start(particles);
    for (const std::size_t s : order) {
      const RealBuffer grads = buffer(shards[s].grads);
      stage.set_columns(shards[s].columns);
      other.set_columns(shards[s].columns);
      if (packed) {
        stage.add_packed(other.pack(grads, rows), share);  // from another rank
      } else {
        stage.add(grads, share);
      }
    }
    keys = stage.keys().download();
    return stage.sums().download_float();
  }
  RealBuffer buffer(const std::vector<float>& values) const {
    RealBuffer out(device, "values", Precision::kFloat, values.size());
    out.upload(std::span<const float>(values));
    return out;
  }
  std::vector<std::uint32_t> keys;
};

TEST_F(ShardSumTest, IsOneRoundingPerShardInTheirOrder) {
  const std::vector<float> found = sum({0, 1, 2}, false);
  const auto share = static_cast<float>(1.0 / 3.0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t i = 0; i < particles.count; ++i) {
      float expected = 0.0F;
      for (const Shard& s : shards) {
        if (s.keys[i] != kCulled) expected = std::fma(share, s.grads[row * stride + i], expected);
      }
      ASSERT_EQ(found[row * stride + i], expected) << row << " " << i;
    }
  }
  for (std::size_t i = 0; i < particles.count; ++i) {
    const bool is_shown =
        shards[0].keys[i] != kCulled || shards[1].keys[i] != kCulled || shards[2].keys[i] != kCulled;
    ASSERT_EQ(keys[i], is_shown ? 0U : kCulled) << i;
  }
}

TEST_F(ShardSumTest, PackedAddsTheSameBits) {
  EXPECT_TRUE(sum({0, 1, 2}, true) == sum({0, 1, 2}, false));
  EXPECT_FALSE(sum({2, 1, 0}, true) == sum({0, 1, 2}, true));  // the order shows
}

TEST_F(ShardSumTest, ColumnsAreThoseThatAreShown) {
  Buffer<std::uint32_t> from(device, "keys", shards[0].keys);
  EXPECT_EQ(ShardSum::columns_of(from), shards[0].columns);
}

TEST_F(ShardSumTest, ErrorsAndWholeMatricesAreAddedToo) {
  ShardSum stage(device, Precision::kFloat);
  stage.start(particles);
  const Shard& shard = shards[1];
  std::vector<float> errors(shard.grads.begin(),
                            shard.grads.begin() + static_cast<std::ptrdiff_t>(particles.count));
  stage.set_columns(shard.columns);
  RealBuffer one = buffer(std::vector<float>(particles.count, 1.0F)), other = buffer(one.download_float());
  stage.add_errors(buffer(errors), one);
  stage.add_packed_errors(stage.pack(buffer(errors), 1), other);
  EXPECT_EQ(one.download_float(), other.download_float());
  for (std::size_t i = 0; i < particles.count; ++i) {
    ASSERT_EQ(one.download_float()[i], shard.keys[i] == kCulled ? 1.0F : 1.0F + errors[i]) << i;
  }
  RealBuffer sum = buffer(std::vector<float>(particles.count, 2.0F));
  stage.add_all(errors, 0.5, sum);
  const std::vector<float> all = sum.download_float();
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], std::fma(0.5F, errors[i], 2.0F)) << i;
}

TEST_F(ShardSumTest, OtherSizesAreRefused) {
  ShardSum stage(device, Precision::kFloat);
  stage.start(particles);
  const std::vector<std::uint32_t> beyond{particles.count};
  EXPECT_THROW(stage.set_columns(beyond), Error);
  stage.set_columns(shards[0].columns);
  EXPECT_THROW(stage.add_packed(std::vector<float>(3), 1.0), Error);
  EXPECT_THROW(stage.add(buffer(std::vector<float>(3)), 1.0), Error);
}

}  // namespace
}  // namespace simuli
