#include <algorithm>
#include <cmath>
#include <concepts>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <numbers>

#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/info/info.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli::cli {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

struct Extremes {
  double low = 0.0;
  double high = 0.0;
};

template <class Values, class Value>
Extremes span_of(const Values& values, Value&& value) {
  Extremes span{value(*values.begin()), value(*values.begin())};
  for (const auto& element : values) {
    span.low = std::min(span.low, value(element));
    span.high = std::max(span.high, value(element));
  }
  return span;
}

Extremes span_of(const std::vector<double>& values) {
  return span_of(values, [](double value) { return value; });
}

std::string to_text(const Extremes& span, double scale, int digits) {
  return fmt::format("{:.{}f} to {:.{}f}", span.low * scale, digits, span.high * scale, digits);
}

/// Returns "" if all values are zero.
std::string offsets_text(const std::vector<LidarRow>& rows,
                         double LidarRow::*field,
                         const char* name,
                         double scale,
                         int digits,
                         const char* unit) {
  const Extremes span = span_of(rows, [field](const LidarRow& row) { return row.*field; });
  if (span.low == 0.0 && span.high == 0.0) return "";
  return fmt::format("  {} {} {}\n", name, to_text(span, scale, digits), unit);
}

std::string elevation_text(const Lidar& lidar) {
  const std::size_t rows = lidar.rows.size();
  std::string text = fmt::format("  elevation {:.3f} to {:.3f} deg",
                                 lidar.rows.back().elevation * kDegPerRad,
                                 lidar.rows.front().elevation * kDegPerRad);
  if (rows > 1) {
    std::vector<double> steps;
    for (std::size_t r = 1; r < rows; ++r) {
      steps.push_back(lidar.rows[r - 1].elevation - lidar.rows[r].elevation);
    }
    text += fmt::format(", steps of {} deg", to_text(span_of(steps), kDegPerRad, 3));
  }
  return text + '\n';
}

std::string azimuth_text(const Lidar& lidar) {
  const double step = lidar.azimuth_span / lidar.columns;
  const bool full = std::abs(lidar.azimuth_span - 2.0 * std::numbers::pi) < 1e-6;
  return fmt::format("  azimuth from {:.3f} deg over {:.3f} deg ({}), steps of {:.4f} deg\n",
                     lidar.azimuth_first * kDegPerRad,
                     lidar.azimuth_span * kDegPerRad,
                     full ? "a full revolution" : "a partial field of view",
                     step * kDegPerRad);
}

std::string divergence_text(double beam_divergence, double variance, const LidarFacts& facts) {
  if (beam_divergence == 0.0) return "  divergence unknown or none: ideal rays\n";
  std::string text = fmt::format("  divergence {:.3f} mrad full angle, variance {} of (half angle x range)^2",
                                 beam_divergence * 1e3,
                                 variance);
  if (facts.divergence_horizontal != facts.divergence_vertical) {
    text += fmt::format(" (beam of {:.3f} x {:.3f} mrad)",
                        facts.divergence_horizontal * 1e3,
                        facts.divergence_vertical * 1e3);
  }
  return text + '\n';
}

std::string facts_text(const LidarFacts& facts) {
  std::string text;
  if (!facts.modes.empty()) {
    std::vector<std::string> modes;
    for (const LidarMode& mode : facts.modes) {
      modes.push_back(fmt::format("{}x{}", mode.columns, mode.spin_hz));
    }
    text += fmt::format("  modes (columns x revolutions per second) {}\n", fmt::join(modes, ", "));
  }
  return text + origin_text(facts.source, facts.licence, facts.note);
}

std::string line_of(const Lidar& lidar) {
  return fmt::format(
      "lidar  {:<26} {:3} beams x {} columns, elevation {:.2f} to {:.2f} deg, {}, {:.6g} to {:.6g} m",
      lidar.name,
      lidar.row_count(),
      lidar.columns,
      lidar.rows.back().elevation * kDegPerRad,
      lidar.rows.front().elevation * kDegPerRad,
      lidar.spin == SpinDirection::kClockwise ? "clockwise" : "counter_clockwise",
      lidar.range_min,
      lidar.range_max);
}

std::string line_of(const RayList& list) {
  return fmt::format("ray list {:<14} {} rays, {:.6g} to {:.6g} m",
                     list.name,
                     list.ray_count(),
                     list.range_min,
                     list.range_max);
}

std::string model_text(const Lidar& lidar, const LidarFacts& facts) {
  std::string text = line_of(lidar);
  if (facts.mode.spin_hz > 0.0) text += fmt::format(", {} revolutions per second", facts.mode.spin_hz);
  text += '\n' + elevation_text(lidar) + azimuth_text(lidar);
  const auto add =
      [&](double LidarRow::*field, const char* name, double scale, int digits, const char* unit) {
        text += offsets_text(lidar.rows, field, name, scale, digits, unit);
      };
  add(&LidarRow::azimuth_offset, "beam azimuth offsets", kDegPerRad, 3, "deg");
  add(&LidarRow::vertical_offset, "beam origins up", 1.0, 4, "m");
  add(&LidarRow::horizontal_offset, "beam origins to the left", 1.0, 4, "m");
  add(&LidarRow::radial_offset, "beam origins outwards", 1.0, 4, "m");
  add(&LidarRow::range_bias, "ranges recorded too long", 1.0, 4, "m");
  add(&LidarRow::time_offset, "beam firing times", 1e6, 2, "us");
  const auto slow =
      std::count_if(lidar.rows.begin(), lidar.rows.end(), [](const LidarRow& r) { return r.every > 1; });
  if (slow > 0) {
    std::size_t fired = 0;
    for (int row = 0; row < lidar.row_count(); ++row)
      fired += static_cast<std::size_t>(firings_of(lidar, row));
    text += fmt::format(
        "  {} beams fire in every second column or fewer: {} of {} rays\n", slow, fired, lidar.ray_count());
  }
  return text + divergence_text(lidar.beam_divergence, lidar.divergence_variance, facts);
}

std::string model_text(const RayList& list, const LidarFacts& facts) {
  std::string text = line_of(list) + '\n';
  text += fmt::format("  azimuth {} deg, elevation {} deg\n",
                      to_text(span_of(list.azimuth), kDegPerRad, 3),
                      to_text(span_of(list.elevation), kDegPerRad, 3));
  text += fmt::format("  fired at {} of the frame\n", to_text(span_of(list.time_fraction), 1.0, 4));
  if (!list.origin.empty()) {
    const Extremes reach = span_of(list.origin, [](const Eigen::Vector3d& origin) { return origin.norm(); });
    text += fmt::format("  ray origins {} m from the sensor's\n", to_text(reach, 1.0, 4));
  }
  return text + divergence_text(list.beam_divergence, list.divergence_variance, facts);
}

}  // namespace

std::string lidar_line(const LidarModel& lidar) {
  return std::visit([](const auto& model) { return line_of(model); }, lidar);
}

nlohmann::ordered_json lidar_summary(const LidarModel& model) {
  return std::visit(
      [](const auto& lidar) -> nlohmann::ordered_json {
        nlohmann::ordered_json out = {{"name", lidar.name}, {"rays", lidar.ray_count()}};
        if constexpr (std::same_as<std::decay_t<decltype(lidar)>, Lidar>) {
          out["rows"] = lidar.row_count();
          out["columns"] = lidar.columns;
          out["elevation_min_deg"] = lidar.rows.back().elevation * kDegPerRad;
          out["elevation_max_deg"] = lidar.rows.front().elevation * kDegPerRad;
          out["turns_per_s"] = 1.0 / lidar.sweep_s;
        }
        out["range_min_m"] = lidar.range_min;
        out["range_max_m"] = lidar.range_max;
        return out;
      },
      model);
}

void print_sensor(const LidarFile& lidar, bool json) {
  if (json) {
    std::cout << json_text(to_json(lidar)) << '\n';
  } else {
    std::cout << std::visit([&](const auto& model) { return model_text(model, lidar.facts); }, lidar.model)
              << facts_text(lidar.facts);
  }
}

void print_sensor_names(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& lidars,
                        bool json) {
  if (json) {
    nlohmann::ordered_json models = nlohmann::ordered_json::array();
    for (const std::string& name : cameras) models.push_back(camera_summary(builtin_camera(name)));
    for (const std::string& name : lidars) models.push_back(lidar_summary(builtin_lidar(name)));
    std::cout << json_text(
                     nlohmann::ordered_json{{"cameras", cameras}, {"lidars", lidars}, {"models", models}})
              << '\n';
    return;
  }
  for (const std::string& name : lidars) std::cout << line_of(builtin_lidar(name)) << '\n';
  for (const std::string& name : cameras) std::cout << camera_line(builtin_camera(name)) << '\n';
}

}  // namespace simuli::cli
