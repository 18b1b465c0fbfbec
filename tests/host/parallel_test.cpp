#include "host/core/base/parallel.hpp"

#include <gtest/gtest.h>
#include <stdexcept>
#include <vector>

namespace simuli {
namespace {

TEST(ParallelRanges, VisitsEachIndexOnce) {
  std::vector<int> visits(1000, 0);
  const auto visit = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++visits[i];
  };
  parallel_ranges(visits.size(), visit, 1);
  EXPECT_EQ(visits, std::vector<int>(1000, 1));
}

/// Includes a part in another thread: the last part, on more than one core.
TEST(ParallelRanges, ThrowsWhatAPartThrows) {
  for (const std::size_t bad : {0U, 999U}) {
    const auto refuse = [bad](std::size_t begin, std::size_t end) {
      if (begin <= bad && bad < end) throw std::runtime_error("bad index");
    };
    EXPECT_THROW(parallel_ranges(1000, refuse, 1), std::runtime_error);
  }
}

}  // namespace
}  // namespace simuli
