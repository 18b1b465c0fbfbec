#pragma once
// Compares analytic gradients with central differences, by parameter group.
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli::test {

/// Compares gradients of a parameter matrix. Each error is relative to the largest difference quotient of its
/// group (means, log-scales, ...): groups have different scales, and small entries are sums with
/// cancellation.
class GradientCheck {
 public:
  void add(int row, double analytic, double numeric) { entries_.push_back({row, analytic, numeric}); }

  /// Returns the largest relative error of a group; infinite for NaN, or if all difference quotients of the
  /// group are 0 and the analytic gradient is not.
  [[nodiscard]] double worst(int group) const {
    double scale = 0.0, error = 0.0;
    for (const Entry& e : entries_) {
      if (group_of(e.row) != group) continue;
      if (!(std::isfinite(e.analytic) && std::isfinite(e.numeric))) return HUGE_VAL;
      scale = std::max(scale, std::abs(e.numeric));
      error = std::max(error, std::abs(e.analytic - e.numeric));
    }
    return error > 0.0 ? error / scale : 0.0;
  }
  /// Whether the group has nonzero quotients; otherwise any comparison would pass.
  [[nodiscard]] bool moves(int group) const {
    for (const Entry& e : entries_) {
      if (group_of(e.row) == group && std::abs(e.numeric) > 0.0) return true;
    }
    return false;
  }
  [[nodiscard]] bool passes(double tolerance) const {
    for (int group = 0; group < kGroups; ++group) {
      if (!(worst(group) <= tolerance)) return false;
    }
    return true;
  }
  /// Returns the same with the analytic gradient of one group scaled: a wrong gradient, for tests of this
  /// check.
  [[nodiscard]] GradientCheck scaled(int group, double factor) const {
    GradientCheck other = *this;
    for (Entry& e : other.entries_) e.analytic *= group_of(e.row) == group ? factor : 1.0;
    return other;
  }

  static constexpr int kGroups = 6;
  static constexpr std::array<const char*, kGroups> kGroupNames{
      "mean", "log-scale", "rotation", "opacity", "SH 0", "SH 1.."};
  [[nodiscard]] static int group_of(int row) {
    if (row < kLogScaleRow) return 0;
    if (row < kRotationRow) return 1;
    if (row < kOpacityRow) return 2;
    if (row < kShRow) return 3;
    return row < kShRow + 3 ? 4 : 5;
  }

 private:
  struct Entry {
    int row;
    double analytic, numeric;
  };
  std::vector<Entry> entries_;
};

inline constexpr double kQuotientStep = 1e-4;
// Quotients are accurate to about 1e-9: h^4 f''''' after extrapolation, and 1e-16 |L| / h of rounding.
inline constexpr double kGradientTolerance = 1e-6;
// 24 bits of directions and positions some metres away, squared distances up to 55 in the exponent.
inline constexpr double kFloatGradientTolerance = 1e-2;

/// Returns the central difference of loss(step), extrapolated once.
template <class Loss>
[[nodiscard]] double extrapolated_quotient(const Loss& loss, double h) {
  const auto central = [&](double step) { return (loss(step) - loss(-step)) / (2.0 * step); };
  return (4.0 * central(0.5 * h) - central(h)) / 3.0;
}

/// Difference quotients of `loss` by entries of `values` against `gradient`: the largest error, and the
/// largest error of a gradient that is 1 % off, both relative to the largest quotient.
struct Quotients {
  double error = 0.0;
  double error_if_scaled = 0.0;
};
inline Quotients compare_quotients(const std::vector<double>& gradient,
                                   const std::vector<std::size_t>& entries,
                                   const std::function<double(std::size_t, double)>& loss) {
  Quotients out;
  double largest = 0.0;
  for (const std::size_t i : entries) {
    const double quotient = extrapolated_quotient([&](double step) { return loss(i, step); }, kQuotientStep);
    largest = std::max(largest, std::abs(quotient));
    out.error = std::max(out.error, std::abs(quotient - gradient[i]));
    out.error_if_scaled = std::max(out.error_if_scaled, std::abs(quotient - 1.01 * gradient[i]));
  }
  out.error /= largest;
  out.error_if_scaled /= largest;
  return out;
}

}  // namespace simuli::test
