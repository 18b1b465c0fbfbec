#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/base/error.hpp"
#include "host/sensors/lidar.hpp"

namespace simuli {
namespace {

struct Beam {
  double elevation;        // rad
  double vertical_offset;  // m
};

/// Velodyne HDL-64E S2 of the KITTI car on 2011-09-26, one line fit z = tan(v) rho + Vo / cos(v) per ring
/// over 17 sweeps of raw drive 0013 (residual 0.01 to 0.1 mrad). An angle-only table would be wrong by 2 to
/// 7 mrad: the beams do not meet in one point.
constexpr std::array<Beam, 64> kKittiHdl64e{{
    {0.033801667, 0.20900},
    {0.027470821, 0.20855},
    {0.022773131, 0.20818},
    {0.015211139, 0.20769},
    {0.010101987, 0.20730},
    {0.003152843, 0.20678},
    {-0.001550111, 0.20649},
    {-0.007885954, 0.20601},
    {-0.014018014, 0.20558},
    {-0.020965772, 0.20507},
    {-0.026072762, 0.20469},
    {-0.031996088, 0.20427},
    {-0.038529594, 0.20381},
    {-0.044447660, 0.20339},
    {-0.050157594, 0.20295},
    {-0.056476330, 0.20250},
    {-0.061772911, 0.20212},
    {-0.068693526, 0.20163},
    {-0.073574735, 0.20127},
    {-0.080078129, 0.20082},
    {-0.085762687, 0.20041},
    {-0.091642379, 0.19995},
    {-0.097922110, 0.19948},
    {-0.103992691, 0.19905},
    {-0.110460340, 0.19860},
    {-0.116513776, 0.19816},
    {-0.122156198, 0.19774},
    {-0.127189544, 0.19740},
    {-0.134020230, 0.19689},
    {-0.140637873, 0.19638},
    {-0.145043781, 0.19606},
    {-0.152042552, 0.19555},
    {-0.157535675, 0.12430},
    {-0.167087468, 0.12366},
    {-0.175625365, 0.12314},
    {-0.182752239, 0.12270},
    {-0.191232660, 0.12210},
    {-0.202443625, 0.12142},
    {-0.211447860, 0.12082},
    {-0.219250243, 0.12031},
    {-0.227609789, 0.11977},
    {-0.235355295, 0.11925},
    {-0.245195299, 0.11864},
    {-0.254788660, 0.11800},
    {-0.265092419, 0.11727},
    {-0.273262870, 0.11674},
    {-0.282336667, 0.11613},
    {-0.288922144, 0.11568},
    {-0.299965468, 0.11492},
    {-0.309456644, 0.11430},
    {-0.319803166, 0.11357},
    {-0.328073025, 0.11301},
    {-0.337194006, 0.11233},
    {-0.344455199, 0.11181},
    {-0.352944773, 0.11124},
    {-0.362824709, 0.11062},
    {-0.372092766, 0.11001},
    {-0.382849646, 0.10913},
    {-0.391601054, 0.10845},
    {-0.398909904, 0.10791},
    {-0.407063008, 0.10741},
    {-0.418347750, 0.10643},
    {-0.427718998, 0.10582},
    {-0.436321525, 0.10519},
}};

Lidar kitti_hdl64e() {
  Lidar lidar;
  lidar.name = "kitti_hdl64e";
  for (const Beam& beam : kKittiHdl64e) {
    // The fitted Vo / cos(v) is the height at which the ray crosses the spin axis.
    lidar.rows.push_back({beam.elevation, 0.0, beam.vertical_offset / std::cos(beam.elevation), 0.0, 0.0});
  }
  lidar.columns = 2156;  // 48 us firing cycle at 9.66 Hz
  lidar.azimuth_first = std::numbers::pi * (1.0 - 1.0 / lidar.columns);
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_min = 0.9;
  lidar.range_max = 120.0;
  lidar.beam_divergence = 0.0;  // the table gives none
  return lidar;
}

/// The bench sensor: 64 beams evenly spread over the HDL-64E's field of view, 2650 firings.
Lidar generic64() {
  Lidar lidar;
  lidar.name = "generic64";
  constexpr double kTop = 2.0 * std::numbers::pi / 180.0;
  constexpr double kBottom = -24.8 * std::numbers::pi / 180.0;
  for (int i = 0; i < 64; ++i) lidar.rows.push_back({kTop + (kBottom - kTop) * i / 63.0, 0, 0, 0, 0});
  lidar.columns = 2650;
  lidar.azimuth_first = std::numbers::pi * (1.0 - 1.0 / lidar.columns);
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_min = 0.5;
  lidar.range_max = 120.0;
  return lidar;
}

constexpr std::array<std::pair<const char*, Lidar (*)()>, 2> kBuiltin{{
    {"generic64", generic64},
    {"kitti_hdl64e", kitti_hdl64e},
}};

}  // namespace

std::vector<std::string> builtin_lidar_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : kBuiltin) names.emplace_back(name);
  return names;
}

Lidar builtin_lidar(const std::string& name) {
  for (const auto& [known, make] : kBuiltin) {
    if (name == known) return make();
  }
  throw Error(ErrorKind::kUsage,
              fmt::format("lidar: found \"{}\", allowed {}", name, fmt::join(builtin_lidar_names(), ", ")));
}

}  // namespace simuli
