#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/core/base/spread.hpp"
#include "io/export/drive_parts.hpp"
#include "io/export/road_line.hpp"

namespace simuli {
namespace {

constexpr double kSample_m = 1.0;
constexpr double kSmooth_m = 2.5;  // half width of the filter; shorter variations are not the road's
constexpr double kKnot_m = 5.0;    // largest distance between heights

/// Returns the interpolated height of the line's positions.
double rig_height(const std::vector<RoadPosition>& places, double s_m) {
  const auto after = std::upper_bound(
      places.begin(), places.end(), s_m, [](double s, const RoadPosition& place) { return s < place.s_m; });
  if (after == places.begin()) return places.front().place.z();
  if (after == places.end()) return places.back().place.z();
  const auto before = after - 1;
  const double share =
      (s_m - before->s_m) / (after->s_m - before->s_m);  // after is beyond s_m, before is not
  return before->place.z() + share * (after->place.z() - before->place.z());
}

struct LinePoint {
  double s_m;
  Eigen::Vector2d place;
};

/// Returns samples every kSample_m or less, including both ends.
std::vector<LinePoint> samples_of(const RoadLine& line) {
  const int steps = std::max(2, static_cast<int>(std::ceil(line.length_m() / kSample_m)));
  std::vector<LinePoint> out;
  double before = 0.0;
  std::size_t piece = 0;
  for (int i = 0; i <= steps; ++i) {
    const double s = line.length_m() * i / steps;
    while (piece + 1 < line.pieces.size() && s > before + line.pieces[piece].length_m) {
      before += line.pieces[piece++].length_m;
    }
    out.push_back({s, line.pieces[piece].at(s - before)});
  }
  return out;
}

/// Returns the road's height at each sample, m.
std::vector<double> heights_of(const RoadLine& line,
                               const std::vector<LinePoint>& samples,
                               const GroundMap& ground) {
  std::vector<std::optional<double>> known;
  std::vector<double> above;
  for (const LinePoint& sample : samples) {
    known.push_back(ground.height_m(sample.place.x(), sample.place.y()));
    if (known.back()) above.push_back(rig_height(line.places, sample.s_m) - *known.back());
  }
  const double usual = upper_median(std::move(above));
  std::vector<double> raw;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    raw.push_back(known[i] ? *known[i] : rig_height(line.places, samples[i].s_m) - usual);
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // Symmetric windows, so that a slope stays linear up to its ends.
    double sum = raw[i], count = 1.0;
    for (std::size_t k = 1; k <= i && i + k < samples.size(); ++k) {
      if (samples[i + k].s_m - samples[i].s_m > kSmooth_m) break;
      sum += raw[i - k] + raw[i + k];
      count += 2.0;
    }
    out.push_back(sum / count);
  }
  return out;
}

/// Returns C1 cubics through about every fifth height.
std::string elevation_of(const std::vector<LinePoint>& samples, const std::vector<double>& heights) {
  const std::size_t last = samples.size() - 1;
  const double per_sample = samples[1].s_m - samples[0].s_m;
  const auto pieces =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(samples.back().s_m / kKnot_m)));
  std::vector<std::size_t> knots;
  for (std::size_t i = 0; i <= pieces; ++i) knots.push_back(last * i / pieces);
  const auto slope = [&](std::size_t knot) {
    const std::size_t a = knots[knot == 0 ? 0 : knot - 1], b = knots[std::min(knot + 1, pieces)];
    return (heights[b] - heights[a]) / (per_sample * static_cast<double>(b - a));
  };
  std::string out;
  for (std::size_t i = 0; i < pieces; ++i) {
    const double length = per_sample * static_cast<double>(knots[i + 1] - knots[i]);
    const double rise = (heights[knots[i + 1]] - heights[knots[i]]) / length;
    const double from = slope(i), to = slope(i + 1);
    out +=
        fmt::format("      <elevation s=\"{:.6f}\" a=\"{:.6f}\" b=\"{:.9f}\" c=\"{:.9e}\" d=\"{:.9e}\"/>\n",
                    samples[knots[i]].s_m,
                    heights[knots[i]],
                    from,
                    (3.0 * rise - 2.0 * from - to) / length,
                    (from + to - 2.0 * rise) / (length * length));
  }
  return out;
}

std::string plan_of(const RoadLine& line) {
  std::string out;
  double s = 0.0;
  for (const RoadPiece& piece : line.pieces) {
    out += fmt::format(
        "      <geometry s=\"{:.9f}\" x=\"{:.9f}\" y=\"{:.9f}\" hdg=\"{:.12f}\" length=\"{:.9f}\">",
        s,
        piece.start.x(),
        piece.start.y(),
        piece.heading_rad,
        piece.length_m);
    out += piece.curvature_per_m == 0.0 ? std::string("<line/>")
                                        : fmt::format("<arc curvature=\"{:.12e}\"/>", piece.curvature_per_m);
    out += "</geometry>\n";
    s += piece.length_m;
  }
  return out;
}

std::string lane(int id) {
  constexpr const char* kMark =
      R"(<roadMark sOffset="0" type="none" weight="standard" color="standard" width="0" laneChange="none"/>)";
  if (id == 0) return fmt::format("<lane id=\"0\" type=\"none\" level=\"false\">{}</lane>", kMark);
  return fmt::format(
      "<lane id=\"{}\" type=\"driving\" level=\"false\"><width sOffset=\"0\" a=\"{}\" b=\"0\" c=\"0\" "
      "d=\"0\"/>{}</lane>",
      id,
      kLaneWidth_m,
      kMark);
}

}  // namespace

std::string road_map(const std::vector<Pose>& rig, const GroundMap& ground) {
  const RoadLine line = road_line(rig);
  const std::vector<LinePoint> samples = samples_of(line);
  Eigen::Vector2d low = samples.front().place, high = low;
  for (const LinePoint& sample : samples) {
    low = low.cwiseMin(sample.place);
    high = high.cwiseMax(sample.place);
  }
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n"
      "  <header revMajor=\"1\" revMinor=\"4\" name=\"Made from the recorded path, not from a survey\" "
      "version=\"1.00\" north=\"{:.3f}\" south=\"{:.3f}\" east=\"{:.3f}\" west=\"{:.3f}\" "
      "vendor=\"simuli\"/>\n"
      "  <road name=\"recorded path\" length=\"{:.9f}\" id=\"1\" junction=\"-1\">\n    <planView>\n",
      high.y(),
      low.y(),
      high.x(),
      low.x(),
      line.length_m());
  out += plan_of(line);
  out +=
      "    </planView>\n    <elevationProfile>\n" + elevation_of(samples, heights_of(line, samples, ground));
  out += fmt::format(
      "    </elevationProfile>\n    <lanes>\n      <laneOffset s=\"0\" a=\"{}\" b=\"0\" c=\"0\" d=\"0\"/>\n"
      "      <laneSection s=\"0\">\n        <left>{}</left>\n        <center>{}</center>\n"
      "        <right>{}</right>\n      </laneSection>\n    </lanes>\n  </road>\n</OpenDRIVE>\n",
      0.5 * kLaneWidth_m,
      lane(1),
      lane(0),
      lane(-1));
  return out;
}

}  // namespace simuli
