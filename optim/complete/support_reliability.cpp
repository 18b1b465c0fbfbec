#include "optim/complete/support_reliability.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {
namespace {

/// Ranks in ascending order; equal values share their mean rank.
std::vector<double> ranks(const std::vector<float>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> out(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first + 1;
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    for (std::size_t i = first; i < end; ++i) out[order[i]] = 0.5 * static_cast<double>(first + end - 1);
    first = end;
  }
  return out;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

/// Removes the tint and tone curve common to the supported pixels: the transform with the least absolute
/// errors, by reweighted least squares, so that local errors have little influence.
Image without_tint(const Image& rendered, const Image& truth, const std::vector<float>& support) {
  constexpr int kRounds = 6;
  constexpr float kSupported = 0.5F;
  constexpr std::ptrdiff_t kFewest = 100;  // twenty-one parameters are fitted
  const auto is_supported = [](float known) { return known > kSupported; };
  if (std::count_if(support.begin(), support.end(), is_supported) < kFewest) return rendered;
  constexpr double kLeastError = 0.02;
  Image corrected = rendered;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> weight(support.size());
    for (std::size_t i = 0; i < support.size(); ++i) {
      if (!is_supported(support[i])) continue;
      const double error = round == 0 ? 1.0 : colour_error(corrected, truth, i);
      weight[i] = static_cast<float>(1.0 / std::max(error, kLeastError));
    }
    corrected = colour_corrected(rendered, truth, weight, Tone::kQuadratic);
  }
  return corrected;
}

}  // namespace

double colour_error(const Image& rendered, const Image& truth, std::size_t pixel) {
  double sum = 0.0;
  for (std::size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) {
    sum += std::abs(static_cast<double>(rendered.data[c] - truth.data[c]));
  }
  return sum / 3.0;
}

void SupportSamples::append(const SupportSamples& others) {
  support.insert(support.end(), others.support.begin(), others.support.end());
  error.insert(error.end(), others.error.begin(), others.error.end());
}

void SupportSamples::add_picture(SceneOnDevice& scene,
                                 SupportOnDevice& support_on,
                                 const Log& log,
                                 const ImageFrame& frame,
                                 const Camera& camera,
                                 std::size_t step,
                                 Tint tint) {
  const Frame taken = scene.render(Sensor(camera), shot_of(log, frame));
  const std::vector<float> known = support_on.of(taken, scene.scene());
  const Image truth = load_image(log, frame, camera);
  const Image rendered = tint == Tint::kKnown ? taken.image() : without_tint(taken.image(), truth, known);
  for (std::size_t i = 0; i < known.size(); i += step) {
    if (truth.data[3 * i] < 0.0F) continue;  // masked
    support.push_back(known[i]);
    error.push_back(static_cast<float>(colour_error(rendered, truth, i)));
  }
}

void SupportSamples::add_sweep(SceneOnDevice& scene,
                               SupportOnDevice& support_on,
                               const Log& log,
                               const SweepFrame& frame,
                               std::size_t step) {
  const LidarModel& lidar = log.lidar(frame.lidar).model;
  const Sweep recorded = read_sweep(log, frame, lidar);
  const Frame taken = scene.render(Sensor(lidar).with_rays(recorded.rays), shot_of(log, frame));
  const std::vector<float> known = support_on.of(taken, scene.scene());
  const RayResults& rays = taken.results();
  for (std::size_t i = 0; i < known.size(); i += step) {
    const bool returns = recorded.range[i] > 0.0F, is_rendered = rays.drop_probability(i) <= 0.5F;
    const float off_m = returns && is_rendered   ? std::abs(best_distance(rays, i) - recorded.range[i])
                        : returns == is_rendered ? 0.0F
                                                 : kNoReturn_m;
    support.push_back(known[i]);
    error.push_back(std::min(off_m, kNoReturn_m));
  }
}

SupportReliability reliability(const SupportSamples& samples, double limit) {
  SupportReliability out;
  out.count = samples.support.size();
  if (out.count == 0) return out;
  const auto n = static_cast<double>(out.count);
  for (std::size_t i = 0; i < out.count; ++i) {
    const auto support = static_cast<double>(samples.support[i]),
               error = static_cast<double>(samples.error[i]);
    constexpr auto kLast = static_cast<double>(SupportReliability::kBins - 1);
    const double place = std::clamp(support * static_cast<double>(SupportReliability::kBins), 0.0, kLast);
    SupportReliability::Bin& bin = out.bins[static_cast<std::size_t>(place)];
    const double is_right = error < limit ? 1.0 : 0.0;
    ++bin.count;
    bin.support += support, bin.right += is_right, bin.error += error;
    out.mean_support += support / n, out.right += is_right / n;
  }
  for (SupportReliability::Bin& bin : out.bins) {
    if (bin.count == 0) continue;
    const auto count = static_cast<double>(bin.count);
    bin.support /= count, bin.right /= count, bin.error /= count;
    out.calibration_error += std::abs(bin.support - bin.right) * count / n;
  }
  out.rank_correlation = -correlation(ranks(samples.support), ranks(samples.error));
  return out;
}

}  // namespace simuli
