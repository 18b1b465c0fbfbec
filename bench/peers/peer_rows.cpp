// Output of `simuli bench --peers`.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>

#include "bench/peers/peers.hpp"

namespace simuli::bench {

double picture_psnr_db(const RayResults& a, const RayResults& b) {
  double square = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < a.rays; ++i) {
      const double error = static_cast<double>(std::clamp(a.feature[c][i], 0.0F, 1.0F)) -
                           static_cast<double>(std::clamp(b.feature[c][i], 0.0F, 1.0F));
      square += error * error;
    }
  }
  return -10.0 * std::log10(square / (3.0 * static_cast<double>(a.rays)));
}

std::vector<double> distance_differences(const RayResults& a, const RayResults& b) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.rays; ++i) {
    if (!(a.median[i] > 0.0F && b.median[i] > 0.0F)) continue;
    differences.push_back(std::abs(static_cast<double>(a.median[i]) - static_cast<double>(b.median[i])));
  }
  std::sort(differences.begin(), differences.end());
  return differences;
}

std::vector<Row> peer_rows(const std::vector<PeerCase>& cases) {
  std::vector<Row> rows;
  for (const PeerCase& c : cases) {
    const std::string base = fmt::format("peers/{}_{}k/", c.sensor, c.particles / 1000);
    const auto put = [&](const char* name, const Spread& s, const char* unit) {
      rows.push_back({base + name, s.median, unit, s.half_iqr});
    };
    put("ours", c.ours_ms, "ms");
    put("ours_blend", c.blend_ms, "ms");
    put("ours_alike", c.alike_ms, "ms");
    put("embree_prepare", c.prepare_ms, "ms");
    put("embree_trace", c.trace_ms, "ms");
    put("embree_build", {c.build_ms, 0.0}, "ms");
    put("ratio", c.ratio, "x");
    put("ratio_blend", c.blend_ratio, "x");
    put("ratio_alike", c.alike_ratio, "x");
    if (c.is_camera()) {
      put("psnr", {c.ours_psnr_db, 0.0}, "dB");
      put("psnr_alike", {c.alike_psnr_db, 0.0}, "dB");
    } else {
      put("distance_median", {c.ours_median_m, 0.0}, "m");
      put("distance_mean", {c.ours_mean_m, 0.0}, "m");
      put("distance_alike_median", {c.alike_median_m, 0.0}, "m");
      put("distance_alike_mean", {c.alike_mean_m, 0.0}, "m");
    }
  }
  return rows;
}

std::string peer_table(const std::vector<PeerCase>& cases) {
  std::string out = fmt::format("{:<15} {:>9} {:>14} {:>8} {:>16} {:>7} {:>15} {:>15} {:>15}  {}\n",
                                "sensor",
                                "particles",
                                "ours (blend)",
                                "alike",
                                "Embree (trace)",
                                "build",
                                "ratio",
                                "trace/blend",
                                "ratio to alike",
                                "from Embree's: ours, alike");
  const auto ratio = [](const Spread& s) { return fmt::format("{:.2f} +- {:.2f}", s.median, s.half_iqr); };
  const auto part = [](double whole, double of) { return fmt::format("{:.1f} ({:.1f})", whole, of); };
  for (const PeerCase& c : cases) {
    out += fmt::format("{:<15} {:>9} {:>14} {:>8.1f} {:>16} {:>7.0f} {:>15} {:>15} {:>15}",
                       c.sensor,
                       c.particles,
                       part(c.ours_ms.median, c.blend_ms.median),
                       c.alike_ms.median,
                       part(c.prepare_ms.median + c.trace_ms.median, c.trace_ms.median),
                       c.build_ms,
                       ratio(c.ratio),
                       ratio(c.blend_ratio),
                       ratio(c.alike_ratio));
    out += c.is_camera() ? fmt::format("  {:.1f} dB, {:.1f} dB\n", c.ours_psnr_db, c.alike_psnr_db)
                         : fmt::format("  median {:.2g} and {:.2g} mm, mean {:.2g} and {:.2g} mm\n",
                                       1e3 * c.ours_median_m,
                                       1e3 * c.alike_median_m,
                                       1e3 * c.ours_mean_m,
                                       1e3 * c.alike_mean_m);
  }
  return out + "ms but for ratios; alike: each ray's own order and exact extents, as the tracer's\n";
}

}  // namespace simuli::bench
