// Tests ranks in threads: communication and termination.
#include "optim/train/ranks/ranks.hpp"

#include <algorithm>
#include <atomic>
#include <gtest/gtest.h>
#include <vector>

namespace simuli {
namespace {

Ranks::Bytes bytes_of(std::size_t count, std::size_t value) {
  return Ranks::Bytes(count, std::byte{static_cast<unsigned char>(value)});
}

TEST(Ranks, EveryRankGetsWhatEachHasGiven) {
  constexpr std::size_t kRanks = 4;
  constexpr std::size_t kRounds = 200;
  std::atomic<std::size_t> right = 0;
  run_rank_threads(kRanks, [&](Ranks& ranks) {
    for (std::size_t round = 0; round < kRounds; ++round) {
      // Each rank sends another number of bytes, some none.
      const Ranks::Bytes own = bytes_of((ranks.rank() * round) % 7, ranks.rank() + round);
      const auto all = ranks.all_gather(own);
      bool is_right = all.size() == kRanks;
      for (std::size_t r = 0; is_right && r < kRanks; ++r) {
        is_right = std::ranges::equal(all[r], bytes_of((r * round) % 7, r + round));
      }
      right += is_right ? 1 : 0;
    }
    EXPECT_TRUE(ranks.any(ranks.rank() == 2));
    EXPECT_FALSE(ranks.any(false));
    EXPECT_TRUE(ranks.first(ranks.rank() == 0));
    EXPECT_FALSE(ranks.first(ranks.rank() != 0));
    ranks.wait_for_all();
  });
  EXPECT_EQ(right, kRanks * kRounds);
}

TEST(Ranks, OneThatEndsTakesTheOthersWithIt) {
  for (const std::size_t failing : {0U, 2U}) {
    try {
      run_rank_threads(3, [&](Ranks& ranks) {
        ranks.wait_for_all();
        if (ranks.rank() == failing) throw Error(ErrorKind::kInput, "the disk");
        for (;;) ranks.wait_for_all();
      });
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "the disk");
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
    }
  }
}

TEST(Ranks, TheOneThatDiffersIsNamed) {
  std::atomic<int> refused = 0;
  try {
    run_rank_threads(3, [&](Ranks& ranks) {
      EXPECT_NO_THROW(need_same(ranks, {{"device", "a"}, {"driver", "1"}}));
      try {
        need_same(ranks, {{"device", "a"}, {"driver", ranks.rank() == 2 ? "2" : "1"}});
      } catch (const RanksDiffer&) {
        ++refused;
        throw;
      }
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const RanksDiffer& differ) {
    EXPECT_STREQ(differ.what(), "rank 2: driver: found 2, expected 1 of rank 0");
  }
  EXPECT_EQ(refused, 3);
  EXPECT_NO_THROW(need_same(one_rank(), {{"device", "a"}}));
}

TEST(Ranks, WhatIsSentComesBackAndShorterBytesAreRefused) {
  const std::vector<double> numbers{1.5, -0.0, 1e300};
  RankWriter writer;
  writer.put(numbers);
  writer.put(std::vector<std::uint32_t>{});
  writer.put(std::string("a"));
  const Ranks::Bytes bytes = writer.take();
  RankReader reader(bytes);
  std::vector<double> found;
  std::vector<std::uint32_t> none{7};
  std::string text;
  reader.get(found);
  reader.get(none);
  reader.get(text);
  EXPECT_EQ(found, numbers);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(text, "a");
  EXPECT_THROW(reader.get(found), Error);
  RankWriter again{Ranks::Bytes(bytes)};
  const std::span<float> room = again.room<float>(2);
  room[0] = 2.5F;
  room[1] = -0.0F;
  const Ranks::Bytes viewed = again.take();
  EXPECT_EQ(viewed.size(), sizeof(std::uint64_t) + 2 * sizeof(float));
  RankReader view(viewed);
  const std::span<const float> values = view.view<float>();
  ASSERT_EQ(values.size(), 2U);
  EXPECT_EQ(values[0], 2.5F);
  EXPECT_THROW((void)view.view<float>(), Error);
  RankReader cut(std::span<const std::byte>(bytes.data(), 20));
  EXPECT_THROW(cut.get(found), Error);
}

}  // namespace
}  // namespace simuli
