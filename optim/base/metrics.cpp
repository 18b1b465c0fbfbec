#include "optim/base/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <nanoflann.hpp>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr double kDropThreshold = 0.5;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr char kWhere[] = "compare_sweep";

/// Points for nanoflann. In double, because single-precision squared differences would lose millimetres.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;  // m

  // Names of nanoflann's dataset interface.
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // nanoflann computes it
  }
};

struct NeighbourSums {
  double squared_m2 = 0.0;
  double distance_m = 0.0;
};

/// Sums over `from` of the exact distance to the nearest point of `to`, which must not be empty.
NeighbourSums sum_nearest(const PointCloud& from, const PointCloud& to) {
  using Tree = nanoflann::
      KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>, PointCloud, 3, std::size_t>;
  const Tree tree(3, to);  // builds the tree
  NeighbourSums sums;
  for (const Eigen::Vector3d& point : from.points) {
    std::size_t index = 0;
    double squared_m2 = kNaN;
    tree.knnSearch(point.data(), 1, &index, &squared_m2);
    sums.squared_m2 += squared_m2;
    sums.distance_m += std::sqrt(squared_m2);
  }
  return sums;
}

template <class Values>
void check_count(const char* field, const Values& values, std::size_t rays) {
  if (values.size() != rays) {
    throw_input_error(kWhere, field, std::to_string(values.size()), fmt::format("{} values", rays));
  }
}

void check_sweep(const SweepComparison& sweep) {
  const std::size_t rays = sweep.range.size();
  check_count("intensity", sweep.intensity, rays);
  check_count("drop", sweep.drop, rays);
  check_count("truth_range", sweep.truth_range, rays);
  check_count("truth_intensity", sweep.truth_intensity, rays);
  check_count("origin", sweep.origin, rays);
  check_count("direction", sweep.direction, rays);
  const auto refuse = [](std::size_t ray, const char* field, float found, const char* allowed) {
    throw_input_error(kWhere, fmt::format("{}[{}]", field, ray), fmt::format("{}", found), allowed);
  };
  for (std::size_t i = 0; i < rays; ++i) {
    // Non-finite values have no order: medians and nearest neighbours would be arbitrary.
    if (!std::isfinite(sweep.range[i])) refuse(i, "range", sweep.range[i], "finite");
    if (!std::isfinite(sweep.intensity[i])) refuse(i, "intensity", sweep.intensity[i], "finite");
    if (!(sweep.drop[i] >= 0.0F && sweep.drop[i] <= 1.0F)) refuse(i, "drop", sweep.drop[i], "0 to 1");
    if (!(sweep.truth_range[i] >= 0.0F && std::isfinite(sweep.truth_range[i]))) {
      refuse(i, "truth_range", sweep.truth_range[i], "finite, 0 for no return");
    }
    if (!std::isfinite(sweep.truth_intensity[i])) {
      refuse(i, "truth_intensity", sweep.truth_intensity[i], "finite");
    }
    if (!sweep.origin[i].allFinite()) refuse(i, "origin", sweep.origin[i].sum(), "finite");
    if (!sweep.direction[i].allFinite()) refuse(i, "direction", sweep.direction[i].sum(), "finite");
  }
}

/// Counts of predicted and of true ray drops.
struct DropCounts {
  std::size_t rays = 0, dropped = 0, said = 0, found = 0;

  void add(bool drops, bool says_dropped) {
    ++rays;
    dropped += drops ? 1U : 0U;
    said += says_dropped ? 1U : 0U;
    found += drops && says_dropped ? 1U : 0U;
  }
  void store(SweepMetrics& metrics) const {
    // 0/0 gives the NaN of the contract.
    const auto share = [](std::size_t part, std::size_t of) {
      return static_cast<double>(part) / static_cast<double>(of);
    };
    metrics.raydrop_accuracy = share(rays - dropped - said + 2 * found, rays);
    metrics.raydrop_trivial = share(rays - dropped, rays);
    metrics.drop_recall = share(found, dropped);
    metrics.drop_precision = share(found, said);
  }
};

Eigen::Vector3d point_on_ray(const SweepComparison& sweep, std::size_t ray, double range_m) {
  return sweep.origin[ray].cast<double>() + range_m * sweep.direction[ray].cast<double>();
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return kNaN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

SweepMetrics compare_sweep(const SweepComparison& sweep) {
  check_sweep(sweep);
  PointCloud predicted;
  PointCloud returned;
  std::vector<double> errors_m;
  std::vector<double> squared_errors_m2;
  double relative_sum = 0.0;
  double intensity_sum = 0.0;
  DropCounts drops;
  const std::size_t rays = sweep.range.size();
  for (std::size_t i = 0; i < rays; ++i) {
    const double range_m = sweep.range[i];
    const double truth_m = sweep.truth_range[i];
    const bool truth_returned = truth_m > 0.0;
    const bool says_dropped = sweep.drop[i] > kDropThreshold;
    drops.add(!truth_returned, says_dropped);
    if (!says_dropped) predicted.points.push_back(point_on_ray(sweep, i, range_m));
    if (!truth_returned) continue;
    returned.points.push_back(point_on_ray(sweep, i, truth_m));
    const double error_m = range_m - truth_m;
    const double intensity_error =
        static_cast<double>(sweep.intensity[i]) - static_cast<double>(sweep.truth_intensity[i]);
    errors_m.push_back(std::abs(error_m));
    squared_errors_m2.push_back(error_m * error_m);
    relative_sum += (error_m / truth_m) * (error_m / truth_m);
    intensity_sum += intensity_error * intensity_error;
  }

  // 0/0 gives NaN here as well.
  const auto returns = static_cast<double>(returned.points.size());
  SweepMetrics metrics;
  metrics.distance_median_m = median(std::move(errors_m));
  metrics.medl2_m2 = median(std::move(squared_errors_m2));
  metrics.mean_rel_l2 = relative_sum / returns;
  metrics.intensity_rmse = std::sqrt(intensity_sum / returns);
  drops.store(metrics);
  metrics.chamfer_m2 = kNaN;
  metrics.chamfer_m = kNaN;
  if (!predicted.points.empty() && !returned.points.empty()) {
    const NeighbourSums to_truth = sum_nearest(predicted, returned);
    const NeighbourSums to_predicted = sum_nearest(returned, predicted);
    metrics.chamfer_m2 = (to_truth.squared_m2 + to_predicted.squared_m2) / returns;
    metrics.chamfer_m = 0.5 * (to_truth.distance_m / static_cast<double>(predicted.points.size()) +
                               to_predicted.distance_m / returns);
  }
  return metrics;
}

}  // namespace simuli
