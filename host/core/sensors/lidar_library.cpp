#include "host/core/sensors/lidar_library.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/tables/lidar_tables.hpp"

namespace simuli {
namespace {

struct Beam {
  double elevation;        // rad
  double vertical_offset;  // m
};

/// Velodyne HDL-64E S2 of the KITTI car on 2011-09-26, a line fit z = tan(v) rho + Vo / cos(v) per ring over 17
/// sweeps of raw drive 0013 (residual 0.01 to 0.1 mrad). A table of angles alone would have errors of 2 to 7
/// mrad, because the beams do not meet in one point.
constexpr std::array<Beam, 64> kKittiHdl64e{{
    {0.033801667, 0.20900},  {0.027470821, 0.20855},  {0.022773131, 0.20818},  {0.015211139, 0.20769},
    {0.010101987, 0.20730},  {0.003152843, 0.20678},  {-0.001550111, 0.20649}, {-0.007885954, 0.20601},
    {-0.014018014, 0.20558}, {-0.020965772, 0.20507}, {-0.026072762, 0.20469}, {-0.031996088, 0.20427},
    {-0.038529594, 0.20381}, {-0.044447660, 0.20339}, {-0.050157594, 0.20295}, {-0.056476330, 0.20250},
    {-0.061772911, 0.20212}, {-0.068693526, 0.20163}, {-0.073574735, 0.20127}, {-0.080078129, 0.20082},
    {-0.085762687, 0.20041}, {-0.091642379, 0.19995}, {-0.097922110, 0.19948}, {-0.103992691, 0.19905},
    {-0.110460340, 0.19860}, {-0.116513776, 0.19816}, {-0.122156198, 0.19774}, {-0.127189544, 0.19740},
    {-0.134020230, 0.19689}, {-0.140637873, 0.19638}, {-0.145043781, 0.19606}, {-0.152042552, 0.19555},
    {-0.157535675, 0.12430}, {-0.167087468, 0.12366}, {-0.175625365, 0.12314}, {-0.182752239, 0.12270},
    {-0.191232660, 0.12210}, {-0.202443625, 0.12142}, {-0.211447860, 0.12082}, {-0.219250243, 0.12031},
    {-0.227609789, 0.11977}, {-0.235355295, 0.11925}, {-0.245195299, 0.11864}, {-0.254788660, 0.11800},
    {-0.265092419, 0.11727}, {-0.273262870, 0.11674}, {-0.282336667, 0.11613}, {-0.288922144, 0.11568},
    {-0.299965468, 0.11492}, {-0.309456644, 0.11430}, {-0.319803166, 0.11357}, {-0.328073025, 0.11301},
    {-0.337194006, 0.11233}, {-0.344455199, 0.11181}, {-0.352944773, 0.11124}, {-0.362824709, 0.11062},
    {-0.372092766, 0.11001}, {-0.382849646, 0.10913}, {-0.391601054, 0.10845}, {-0.398909904, 0.10791},
    {-0.407063008, 0.10741}, {-0.418347750, 0.10643}, {-0.427718998, 0.10582}, {-0.436321525, 0.10519},
}};

BuiltinLidar kitti_hdl64e() {
  BuiltinLidar sensor;
  Lidar& lidar = sensor.model;
  lidar.name = "kitti_hdl64e";
  for (const Beam& beam : kKittiHdl64e) {
    // The fitted Vo / cos(v) is the height at which the ray crosses the spin axis.
    lidar.rows.push_back({beam.elevation, 0.0, beam.vertical_offset / std::cos(beam.elevation), 0.0, 0.0});
  }
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_min = 0.9;
  lidar.range_max = 120.0;
  lidar.beam_divergence = 0.0;  // unknown
  sensor.facts.source = "line fits to 17 sweeps of KITTI raw drive 2011_09_26_drive_0013";
  sensor.facts.licence = "the sweeps are CC BY-NC-SA 3.0";
  sensor.facts.note = "Velodyne HDL-64E S2, 48 us firing cycle";
  sensor.facts.modes = {{9.66, 2156}, {10.0, 2083}};
  return sensor;
}

/// The benchmark sensor: 64 beams evenly spread over the HDL-64E's field of view, 2650 firings.
BuiltinLidar generic64() {
  BuiltinLidar sensor;
  Lidar& lidar = sensor.model;
  lidar.name = "generic64";
  constexpr double kTop = 2.0 * std::numbers::pi / 180.0;
  constexpr double kBottom = -24.8 * std::numbers::pi / 180.0;
  for (int i = 0; i < 64; ++i) lidar.rows.push_back({kTop + (kBottom - kTop) * i / 63.0, 0, 0, 0, 0});
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_min = 0.5;
  lidar.range_max = 120.0;
  sensor.facts.source = "an ideal sensor of ours";
  sensor.facts.licence = "ours";
  sensor.facts.modes = {{10.0, 2650}};
  return sensor;
}

double value(std::span<const std::int32_t> list, std::size_t row, double unit) {
  return list.empty() ? 0.0 : list[row] * unit;
}

BuiltinLidar from_table(const LidarTable& table) {
  BuiltinLidar sensor;
  Lidar& lidar = sensor.model;
  lidar.name = table.name;
  for (std::size_t r = 0; r < table.elevation_urad.size(); ++r) {
    LidarRow row;
    row.elevation = table.elevation_urad[r] * 1e-6;
    row.azimuth_offset = value(table.azimuth_offset_urad, r, 1e-6);
    row.time_offset = value(table.time_offset_ns, r, 1e-9);
    // The vertical offset is perpendicular to the beam; the circle of origins rotates with the head, whose
    // angle is the beam's azimuth minus its offset.
    const double tilted = value(table.vertical_offset_100um, r, 1e-4);
    const double circle = table.beam_origin_um * 1e-6;
    row.vertical_offset = tilted * std::cos(row.elevation) + table.height_um * 1e-6;
    row.horizontal_offset =
        value(table.horizontal_offset_100um, r, 1e-4) - circle * std::sin(row.azimuth_offset);
    row.radial_offset = circle * std::cos(row.azimuth_offset) - tilted * std::sin(row.elevation);
    for (const SlowRows& slow : table.slow) {
      const int number = static_cast<int>(r);
      if (number < slow.first || number > slow.last) continue;
      row.every = slow.every;
      row.first = number / slow.group % slow.every;
    }
    lidar.rows.push_back(row);
  }
  lidar.azimuth_span = table.azimuth_span_urad == 0 ? 2.0 * std::numbers::pi : table.azimuth_span_urad * 1e-6;
  lidar.spin = SpinDirection::kClockwise;  // all of these sensors
  lidar.range_min = table.range_min_m;
  lidar.range_max = table.range_max_m;
  sensor.facts.divergence_horizontal = table.divergence_horizontal_urad * 1e-6;
  sensor.facts.divergence_vertical = table.divergence_vertical_urad * 1e-6;
  // One angle for both axes: that of a round beam of equal area.
  lidar.beam_divergence = std::sqrt(sensor.facts.divergence_horizontal * sensor.facts.divergence_vertical);
  lidar.divergence_variance = table.divergence_variance;
  if (table.azimuth_first_urad != LidarTable::kFromBehind) {
    lidar.azimuth_first = table.azimuth_first_urad * 1e-6;
  }
  sensor.facts.source = table.source;
  sensor.facts.licence = table.licence;
  sensor.facts.note = table.note;
  sensor.facts.modes.assign(table.modes.begin(), table.modes.end());
  return sensor;
}

const LidarTable* find_table(const std::string& name) {
  for (const auto& tables : {datasets_lidar_tables(),
                             hesai_lidar_tables(),
                             ouster_lidar_tables(),
                             robosense_lidar_tables(),
                             velodyne_lidar_tables()}) {
    for (const LidarTable& table : tables) {
      if (name == table.name) return &table;
    }
  }
  return nullptr;
}

/// Azimuth of the column whose firing begins at the back.
double from_behind(int columns) { return std::numbers::pi * (1.0 - 1.0 / columns); }

/// Parses the complete text as a number.
template <class T>
std::optional<T> parse(std::string_view text) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Finds the mode of "HZ" or "COLUMNSxHZ".
std::optional<LidarMode> find_mode(const std::vector<LidarMode>& modes, std::string_view text) {
  const std::size_t cross = text.find('x');
  const bool with_columns = cross != std::string_view::npos;
  const auto spin_hz = parse<double>(with_columns ? text.substr(cross + 1) : text);
  const auto columns = with_columns ? parse<int>(text.substr(0, cross)) : std::optional<int>(0);
  if (!spin_hz || !columns) return std::nullopt;
  for (const LidarMode& mode : modes) {
    if (mode.spin_hz == *spin_hz && (!with_columns || mode.columns == *columns)) return mode;
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> builtin_lidar_names() {
  std::vector<std::string> names{"generic64", "kitti_hdl64e"};
  for (const auto& tables : {datasets_lidar_tables(),
                             hesai_lidar_tables(),
                             ouster_lidar_tables(),
                             robosense_lidar_tables(),
                             velodyne_lidar_tables()}) {
    for (const LidarTable& table : tables) names.emplace_back(table.name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

BuiltinLidar builtin_lidar_with_facts(const std::string& name) {
  const std::size_t at = name.find('@');
  const std::string base = name.substr(0, at);
  BuiltinLidar sensor;
  if (base == "generic64") {
    sensor = generic64();
  } else if (base == "kitti_hdl64e") {
    sensor = kitti_hdl64e();
  } else if (const LidarTable* table = find_table(base); table != nullptr) {
    sensor = from_table(*table);
  } else {
    throw Error(ErrorKind::kUsage,
                fmt::format("lidar: found \"{}\", {}allowed those that \"simuli info sensors\" lists",
                            base,
                            did_you_mean(base, builtin_lidar_names())));
  }
  LidarFacts& facts = sensor.facts;
  facts.mode = facts.modes.front();
  if (at != std::string::npos) {
    const auto mode = find_mode(facts.modes, std::string_view(name).substr(at + 1));
    if (!mode) {
      std::vector<std::string> known;
      for (const LidarMode& m : facts.modes) known.push_back(fmt::format("{}x{}", m.columns, m.spin_hz));
      throw Error(ErrorKind::kUsage,
                  fmt::format("lidar {}: mode: found \"{}\", allowed {} (columns x turns per second)",
                              base,
                              name.substr(at + 1),
                              fmt::join(known, ", ")));
    }
    facts.mode = *mode;
  }
  Lidar& lidar = sensor.model;
  lidar.name = name;
  lidar.columns = facts.mode.columns;
  lidar.sweep_s = std::numeric_limits<double>::infinity();  // tables are for a head at rest
  const LidarTable* table = find_table(base);
  if (table == nullptr || table->azimuth_first_urad == LidarTable::kFromBehind)
    lidar.azimuth_first = from_behind(lidar.columns);
  lidar = in_mode(std::move(lidar), facts.mode);
  return sensor;
}

Lidar in_mode(Lidar lidar, const LidarMode& mode) {
  const double faster_hz = mode.spin_hz - 1.0 / lidar.sweep_s;
  if (lidar.azimuth_first == from_behind(lidar.columns)) lidar.azimuth_first = from_behind(mode.columns);
  for (LidarRow& row : lidar.rows)
    row.azimuth_offset += lidar.spin_sign() * 2.0 * std::numbers::pi * faster_hz * row.time_offset;
  lidar.columns = mode.columns;
  lidar.sweep_s = 1.0 / mode.spin_hz;
  return lidar;
}

Lidar builtin_lidar(const std::string& name) { return builtin_lidar_with_facts(name).model; }

}  // namespace simuli
