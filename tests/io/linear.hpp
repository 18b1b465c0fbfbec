#pragma once
// How the time of reading grows with what is read.
#include <algorithm>
#include <ctime>
#include <gtest/gtest.h>
#include <limits>

namespace simuli::test {

/// Twice as much takes at most 2.3 times as long, of the processor: `read(which)` reads the once (0) and the twice
/// (1) as large. Where every entry looks through all before it, it takes four times as long.
template <class Read>
void expect_linear(const Read& read) {
  constexpr int kTries = 3, kMostTries = 12;  // a busy machine needs more to show its least
  constexpr double kMost = 2.3, kNever = std::numeric_limits<double>::infinity();
  double least_s[2] = {kNever, kNever};
  for (int i = 0; i < kTries || (i < kMostTries && least_s[1] >= kMost * least_s[0]); ++i) {
    for (const int which : {0, 1}) {
      const std::clock_t start = std::clock();
      read(which);
      least_s[which] = std::min(least_s[which], static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
  }
  EXPECT_LT(least_s[1], kMost * least_s[0]) << "of " << least_s[0] << " s";
}

}  // namespace simuli::test
