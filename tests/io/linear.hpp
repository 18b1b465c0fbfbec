#pragma once
// Tests the growth of reading time with size.
#include <algorithm>
#include <ctime>
#include <gtest/gtest.h>
#include <limits>

namespace simuli::test {

/// Expects that twice the size takes at most 2.3 times the CPU time: `read(which)` reads the single (0) or
/// the double (1) size. With a linear search per entry the factor is four.
template <class Read>
void expect_linear(const Read& read) {
  constexpr int kTries = 3, kMostTries = 12;  // a busy machine needs more tries for its minimum
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
