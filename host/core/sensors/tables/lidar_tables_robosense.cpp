// Beam tables of RoboSense LiDARs: angles in microradians, lever arms in 0.1 mm, times in ns, top beam first.
// The end of the file names sources and licences.
#include "host/core/sensors/tables/lidar_tables.hpp"

namespace simuli {
namespace {

// clang-format off
constexpr auto kRobosenseBpearlElevation = in_steps_deg<32>(89.5, 2.8125);
constexpr LidarMode kRobosenseBpearlModes[] = {{10.0, 1800}, {5.0, 3600}, {20.0, 900}};
constexpr std::int32_t kRobosenseRs16Elevation[] = {
    261555, 226247, 191560, 157010, 122077, 87464, 52016, 17685, -17310, -52266, -87092, -121709, -156643,
    -191801, -226484, -261789};
constexpr std::int32_t kRobosenseRs16UnitElevation[] = {
    262197, 227375, 191438, 157010, 122693, 88333, 52639, 18247, -16186, -51641, -86968, -121461, -156279,
    -190536, -225950, -261030};
constexpr std::int32_t kRobosenseRs32Elevation[] = {
    262091, 179739, 122480, 80523, 57549, 39783, 29407, 22640, 17453, 12266, 5187, -312, -5812, -11641,
    -17766, -23265, -28470, -34594, -39783, -46548, -52672, -57549, -63691, -70745, -76557, -81144, -94370,
    -111811, -138056, -179135, -255481, -436332};
constexpr std::int32_t kRobosenseRs32AzimuthOffset[] = {
    121194, -157965, 118113, -159183, 119346, -159183, 124887, 31659, -60840, -155347, 124273, 31034, -62336,
    -153338, 127348, 31659, -62336, -152381, 127962, 34907, -59223, -153694, 125503, 32538, -60968, -153694,
    119346, -155525, 118113, -159183, 116263, 116881};
constexpr std::int32_t kRobosenseRuby128Elevation[] = {
    261799, 200713, 157080, 129329, 114494, 104022, 95295, 88314, 82205, 76969, 72606, 69115, 66497, 64752,
    63006, 61261, 59516, 57770, 56025, 54280, 52534, 50789, 49044, 47298, 45553, 43808, 42062, 40317, 38572,
    36826, 35081, 33336, 31590, 29845, 28100, 26354, 24609, 22864, 21118, 19373, 17628, 15882, 14137, 12392,
    10647, 8901, 7156, 5411, 3665, 1920, 175, -1571, -3316, -5061, -6807, -8552, -10297, -12043, -13788,
    -15533, -17279, -19024, -20769, -22515, -24260, -26005, -27751, -29496, -31241, -32987, -34732, -36477,
    -38223, -39968, -41713, -43459, -45204, -46949, -48695, -50440, -52185, -53931, -55676, -57421, -59167,
    -60912, -62657, -64403, -66148, -67893, -69639, -71384, -73129, -74875, -76620, -78365, -80111, -81856,
    -83601, -85347, -87092, -88837, -90583, -92328, -94073, -95819, -97564, -99309, -101055, -102800, -104545,
    -106291, -108036, -109781, -111527, -113446, -116064, -119555, -124791, -133518, -145770, -161338,
    -180572, -204937, -236754, -279986, -341770, -436332};
constexpr auto kRobosenseRuby128AzimuthOffset = repeated<128>(
    std::array{14835, 44506, 74176, 103847, -103847, -74176, -44506, -14835});
constexpr auto kRobosenseRubyLite80Elevation = std::span(kRobosenseRuby128Elevation).last(80);
constexpr auto kRobosenseRubyLite80AzimuthOffset = std::span(kRobosenseRuby128AzimuthOffset).first(80);

constexpr LidarTable kRobosenseTables[] = {
    {.name = "robosense_bpearl", .elevation_urad = kRobosenseBpearlElevation, .modes = kRobosenseBpearlModes,
     .range_min_m = 0.1, .range_max_m = 30.0,
     .source = "RoboSense-LiDAR/ros_rslidar: rslidar_pointcloud/data/rs_bpearl/angle.csv",
     .licence = "BSD-3-Clause",
     .note = "hemispherical, 2.3 to 89.5 deg"},
    {.name = "robosense_rs16", .elevation_urad = kRobosenseRs16Elevation, .modes = kRobosenseBpearlModes,
     .range_min_m = 0.2, .range_max_m = 150.0,
     .source = "RoboSense-LiDAR/ros_rslidar: rslidar_pointcloud/data/rs_lidar_16/angle.csv",
     .licence = "BSD-3-Clause",
     .note = "0.2 deg at 10 Hz, default calibration"},
    {.name = "robosense_rs16_unit", .elevation_urad = kRobosenseRs16UnitElevation,
     .modes = kRobosenseBpearlModes, .range_min_m = 0.2, .range_max_m = 150.0,
     .source = "RoboSense-LiDAR/ros_rslidar: rslidar_pointcloud/data/lidar1/angle.csv",
     .licence = "BSD-3-Clause",
     .note = "0.2 deg at 10 Hz, one unit's calibration"},
    {.name = "robosense_rs32", .elevation_urad = kRobosenseRs32Elevation,
     .azimuth_offset_urad = kRobosenseRs32AzimuthOffset, .modes = kRobosenseBpearlModes, .range_min_m = 0.4,
     .range_max_m = 200.0,
     .source = "RoboSense-LiDAR/ros_rslidar: rslidar_pointcloud/data/rs_lidar_32/angle.csv",
     .licence = "BSD-3-Clause",
     .note = "0.2 deg at 10 Hz"},
    {.name = "robosense_ruby128", .elevation_urad = kRobosenseRuby128Elevation,
     .azimuth_offset_urad = kRobosenseRuby128AzimuthOffset, .modes = kRobosenseBpearlModes,
     .range_min_m = 0.4, .range_max_m = 200.0,
     .source = "PJLab-ADG/LiDARSimLib-and-Placement-Evaluation: "
               "LiDARSimLib/Unreal/CarlaUE4/Plugins/Carla/Source/Carla/Sensor/Surround.cpp",
     .licence = "facts of the vendor's manual",
     .note = "elevations of the manual; azimuth offsets inferred: the period-4 pattern that all 80 "
             "published ones follow"},
    {.name = "robosense_ruby_lite80", .elevation_urad = kRobosenseRubyLite80Elevation,
     .azimuth_offset_urad = kRobosenseRubyLite80AzimuthOffset, .modes = kRobosenseBpearlModes,
     .range_min_m = 0.4, .range_max_m = 230.0,
     .source = "RS-Ruby driver: RSRuby header",
     .licence = "BSD-3-Clause",
     .note = "80 of the 128 beams"},
};
// clang-format on

}  // namespace

std::span<const LidarTable> robosense_lidar_tables() { return kRobosenseTables; }

}  // namespace simuli
