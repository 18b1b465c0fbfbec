#include "io/import/points/points_log.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "host/core/sensors/lidar_library.hpp"
#include "io/base/file.hpp"
#include "io/log/camera_mask.hpp"
#include "io/log/log_json.hpp"
#include "io/synth/street.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace points_log_test {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::Scratch;

/// Files hold float32 coordinates (2e-6 m in the street) and times (1e-8 s of a drive at 8 m/s).
constexpr double kStored_m = 1e-4;
constexpr double kStored_rad = 1e-5;

Log street(const Scratch& scratch) {
  StreetOptions options;
  options.output = scratch / "street.log";
  options.frames = 2;
  options.image_width = 48;
  options.image_height = 27;
  options.lidar_columns = 180;
  return synth_street(options);
}

void put(std::string& to, double value) {
  const auto v = static_cast<float>(value);
  char four[4];
  std::memcpy(four, &v, 4);
  to.append(four, 4);
}

/// Returns the returns in the sensor frame or in the world: x y z intensity, another column, row, time.
std::string points_of(const Log& log, const SweepFrame& frame, bool in_world) {
  const Lidar& lidar = log.lidar(frame.lidar).with_rows();
  const Sweep sweep = read_sweep(log.folder / frame.file, lidar);
  const double duration_s = frame.time_end_s - frame.time_start_s;
  std::string bytes;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;
    const int row = static_cast<int>(i / static_cast<std::size_t>(lidar.columns));
    const double azimuth = sweep.rays.azimuth[i], time_s = sweep.rays.time_fraction[i] * duration_s;
    Eigen::Vector3d p = lidar.origin(row, azimuth) +
                        double{sweep.range[i]} * Lidar::direction(azimuth, sweep.rays.elevation[i]);
    if (in_world) {
      p = log.world_from_rig.at(frame.time_start_s + time_s) * log.lidar(frame.lidar).rig_from_lidar * p;
    }
    for (const double v : {p.x(), p.y(), p.z(), double{sweep.intensity[i]}, -7.0, double(row), time_s}) {
      put(bytes, v);
    }
  }
  return bytes;
}

/// The street in the format of points.json.
class Folder {
 public:
  Folder(const Scratch& scratch, const Log& log, bool in_world, const Json& columns)
      : path(scratch / "drive") {
    fs::remove_all(path);
    fs::create_directories(path / "points");
    json = parse_json(read_file(log.folder / "log.json"), "log.json");
    json["format"] = "simuli points";
    json["point_columns"] = columns;
    json["points_in"] = in_world ? "world" : "sensor";
    for (std::size_t i = 0; i < log.sweeps.size(); ++i) {
      const std::string file = fmt::format("points/{}.bin", i);
      std::ofstream(path / file, std::ios::binary) << points_of(log, log.sweeps[i], in_world);
      json["sweeps"][i]["file"] = file;
    }
    fs::copy(log.folder / "images", path / "images");
    Image hood(48, 27, 1);
    std::fill(hood.data.end() - 48 * 9, hood.data.end(), 1.0F);
    fs::create_directories(path / "masks");
    write_image(path / "masks" / "hood.png", hood);
    json["masks"] = {{{"camera", log.cameras[0].model.name}, {"file", "masks/hood.png"}}};
  }
  [[nodiscard]] const fs::path& write() const {
    std::ofstream(path / "points.json") << json.dump();
    return path;
  }
  fs::path path;
  Json json;
};

const Json kAll = {"x_m", "y_m", "z_m", "intensity", "colour", "row", "time_s"};
const Json kPlaceOnly = {"x_m", "y_m", "z_m", "intensity", "-", "-", "-"};

TEST(PointsLog, TheStreetComesBack) {
  const Scratch scratch;
  const Log log = street(scratch);
  int n = 0;
  for (const bool in_world : {false, true}) {
    for (const Json& columns : {kAll, kPlaceOnly}) {
      if (in_world && columns == kPlaceOnly) continue;  // tested below
      const Folder folder(scratch, log, in_world, columns);
      PointReport report;
      const Log back = import_points({folder.write(), scratch / fmt::format("{}.log", n++)}, {}, report);
      SCOPED_TRACE(back.folder);
      PointReport surveyed;
      expect_survey(import_points({folder.write(), ""}, {}, surveyed), back);
      EXPECT_EQ(surveyed.returned, report.returned);
      ASSERT_EQ(back.sweeps.size(), log.sweeps.size());
      EXPECT_EQ(back.images.size(), log.images.size());
      EXPECT_EQ(back.actors.size(), log.actors.size());
      EXPECT_NEAR(back.hidden.at(log.cameras[0].model.name)->hidden_share(), 1.0 / 3.0, 1e-9);
      EXPECT_EQ(report.unplaced, 0U);
      EXPECT_EQ(report.echoes, 0U);
      EXPECT_EQ(report.returned, report.points);
      const Lidar& lidar = log.lidars.at(0).with_rows();
      std::size_t returned = 0;
      double range_off = 0.0, angle_off = 0.0, time_off = 0.0;
      for (std::size_t s = 0; s < log.sweeps.size(); ++s) {
        EXPECT_NEAR(back.sweeps[s].time_end_s, log.sweeps[s].time_end_s, 1e-9);
        const Sweep a = read_sweep(log.folder / log.sweeps[s].file, lidar);
        const Sweep b = read_sweep(back.folder / back.sweeps[s].file, lidar);
        for (std::size_t i = 0; i < a.range.size(); ++i) {
          ASSERT_EQ(a.range[i] > 0.0F, b.range[i] > 0.0F) << "ray " << i;
          returned += a.range[i] > 0.0F ? 1 : 0;
          range_off = std::max(range_off, std::abs(double{a.range[i]} - double{b.range[i]}));
          EXPECT_EQ(a.intensity[i], b.intensity[i]);
          const double turn =
              std::remainder(double{a.rays.azimuth[i]} - double{b.rays.azimuth[i]}, 2.0 * std::numbers::pi);
          angle_off = std::max({angle_off,
                                std::abs(turn),
                                std::abs(double{a.rays.elevation[i]} - double{b.rays.elevation[i]})});
          time_off =
              std::max(time_off, std::abs(double{a.rays.time_fraction[i]} - double{b.rays.time_fraction[i]}));
        }
      }
      EXPECT_EQ(returned, report.returned);
      EXPECT_LT(range_off, kStored_m);
      EXPECT_LT(angle_off, kStored_rad);
      EXPECT_LT(time_off, 1e-5);
    }
  }
}

TEST(PointsLog, ATableIsOfAnotherUnitAndMode) {
  const Scratch scratch;
  const Log log = street(scratch);
  for (const bool has_columns : {false, true}) {
    Folder folder(scratch, log, false, {"x_m", "y_m", "z_m"});
    Lidar lidar = in_mode(builtin_lidar("velodyne_vlp16"), {20.0, 904});
    std::string bytes;
    std::size_t count = 0;
    for (int c = 0; c < lidar.columns; ++c) {
      for (int r = 0; r < lidar.row_count(); ++r, ++count) {
        const double azimuth = lidar.azimuth(r, c);
        const double elevation = lidar.rows[static_cast<std::size_t>(r)].elevation + 0.005;
        const Eigen::Vector3d p = lidar.origin(r, azimuth) + 10.0 * Lidar::direction(azimuth, elevation);
        for (const double v : {p.x(), p.y(), p.z()}) put(bytes, v);
      }
    }
    Json sweep = folder.json["sweeps"][0];
    folder.json["sweeps"] = {sweep};
    folder.json["images"] = Json::array();
    folder.json["lidars"] = {{{"table", "velodyne_vlp16"},
                              {"name", folder.json["lidars"][0]["name"]},
                              {"rig_from_lidar", folder.json["lidars"][0]["rig_from_lidar"]}}};
    if (has_columns) folder.json["lidars"][0]["columns"] = 904;
    std::ofstream(folder.path / sweep["file"].get<std::string>(), std::ios::binary) << bytes;
    PointReport report;
    const Log back =
        import_points({folder.write(), scratch / fmt::format("unit{}.log", has_columns)}, {}, report);
    const Lidar& found = back.lidars.at(0).with_rows();
    EXPECT_EQ(found.columns, 904);
    EXPECT_NEAR(found.rows[0].elevation, lidar.rows[0].elevation + 0.005, 1e-5);
    EXPECT_EQ(report.returned, count);
    EXPECT_EQ(report.rays, count);
    ASSERT_EQ(report.notes.size(), has_columns ? 1U : 2U);
    EXPECT_NE(report.notes[0].find("another unit: all beams 0.286 degrees higher"), std::string::npos);
  }
}

TEST(PointsLog, TablesByNameAndWhatIsOffThem) {
  Lidar lidar = builtin_lidar("velodyne_vlp16");
  lidar.columns = 360;
  const auto at = [&](int row, double column, double range) {
    const double azimuth =
        lidar.azimuth(row, 0) + lidar.spin_sign() * column * lidar.azimuth_span / lidar.columns;
    const double elevation = lidar.rows[static_cast<std::size_t>(row)].elevation;
    return MeasuredPoint{lidar.origin(row, azimuth) + range * Lidar::direction(azimuth, elevation), 0.5F};
  };
  EXPECT_NEAR(column_of(lidar, 3, lidar.azimuth(3, 359)), 359.0, 1e-9);
  EXPECT_NEAR(column_of(lidar, 3, lidar.azimuth(3, 0) + 4.0 * std::numbers::pi), 0.0, 1e-9);
  std::vector<MeasuredPoint> points{at(5, 10.2, 20.0),
                                    at(5, 11.2, 20.0),
                                    at(5, 11.2, 30.0),  // a second echo
                                    at(6, 359.4, 9.0),
                                    {{0.0, 0.0, 20.0}, 0.5F},  // straight up
                                    {{0.01, 0.0, 0.0}, 0.5F}};
  PointReport report;
  const Sweep sweep = grid_points(points, lidar, report);
  EXPECT_EQ(report.points, 6U);
  EXPECT_EQ(report.unplaced, 2U);
  EXPECT_EQ(report.echoes, 1U);
  EXPECT_EQ(report.returned, 3U);
  EXPECT_NEAR(sweep.range[5 * 360 + 10], 20.0F, 1e-4);
  EXPECT_NEAR(sweep.range[5 * 360 + 11], 20.0F, 1e-4);
  EXPECT_NEAR(sweep.range[6 * 360 + 359], 9.0F, 1e-4);
  // A fifth of a column after the nominal azimuth, for all columns of the row.
  const double fifth = lidar.spin_sign() * 0.2 * lidar.azimuth_span / lidar.columns;
  EXPECT_NEAR(sweep.rays.azimuth[5 * 360 + 200] - lidar.azimuth(5, 200), fifth, 1e-5);
  EXPECT_NEAR(sweep.rays.azimuth[7 * 360 + 200] - lidar.azimuth(7, 200), 0.0, 1e-6);
}

TEST(PointsLog, RaysAtTheSeamAreOfItsEndOrItsStart) {
  Lidar lidar = builtin_lidar("velodyne_vlp16");
  lidar.columns = 360;
  const auto at = [&](int column, double time) {
    const double azimuth = lidar.azimuth(5, column);
    MeasuredPoint point{lidar.origin(5, azimuth) + 20.0 * Lidar::direction(azimuth, lidar.rows[5].elevation),
                        0.5F};
    point.row = 5;
    point.time_fraction = time;
    return point;
  };
  // At this row's azimuth the encoder is ahead: its first columns are measured at the end of the sweep.
  PointReport report;
  const Sweep sweep = grid_points({at(4, 1.002 + 4.5 / 360), at(50, 0.002 + 50.5 / 360)}, lidar, report);
  EXPECT_EQ(report.returned, 2U);
  for (std::size_t column = 0; column < 360; ++column) {
    const double nominal = (static_cast<double>(column) + 0.5) / 360;
    const double off = static_cast<double>(sweep.rays.time_fraction[5 * 360 + column]) - nominal;
    EXPECT_NEAR(off, column < 27 ? 1.002 : 0.002, 2e-3) << column;
  }
}

TEST(PointsLog, SaysWhatDoesNotFit) {
  const Scratch scratch;
  const Log log = street(scratch);
  const auto refuse = [&](const std::function<void(Folder&)>& spoil, const std::vector<std::string>& words) {
    Folder folder(scratch, log, false, kAll);
    spoil(folder);
    PointReport report;
    expect_input_error([&] { (void)import_points({folder.write(), scratch / "x.log"}, {}, report); }, words);
    EXPECT_FALSE(fs::exists(scratch / "x.log"));
  };
  refuse([](Folder& f) { f.json["format"] = "simuli log"; }, {"points.json", "format"});
  refuse(
      [](Folder& f) {
        f.json["point_columns"] = {"x_m", "y_m"};
      },
      {"points.json", "point_columns", "z_m"});
  refuse([](Folder& f) { f.json["point_columns"].push_back("row"); }, {"point_columns", "row twice"});
  refuse([](Folder& f) { f.json["points_in"] = "rig"; }, {"points_in", "rig"});
  refuse(
      [](Folder& f) {
        f.json["points_in"] = "world";
        f.json["point_columns"] = kPlaceOnly;
      },
      {"points.json", "time_s"});
  refuse([](Folder& f) { f.json["extra"] = 1; }, {"points.json", "extra"});
  refuse([](Folder& f) { f.json["sweeps"][0]["file"] = "points/9.bin"; }, {"sweeps[0].file"});
  refuse([](Folder& f) { fs::resize_file(f.path / "points/1.bin", 30); }, {"1.bin", "multiple of 28"});
  refuse(
      [](Folder& f) {
        f.json["point_columns"] = {"row", "x_m", "y_m", "z_m", "-", "-", "-"};
      },
      {"0.bin", "row"});
  refuse(
      [](Folder& f) {
        f.json["lidars"][0] = {{"table", "pandar_64"}, {"name", "top"}};
      },
      {"lidars[0].table", "pandar_64"});
  // A sensor other than the recording one.
  refuse(
      [](Folder& f) {
        const Json mount = f.json["lidars"][0]["rig_from_lidar"];
        f.json["lidars"][0] = {
            {"table", "velodyne_vlp16"}, {"name", "top"}, {"columns", 180}, {"rig_from_lidar", mount}};
        f.json["point_columns"] = kPlaceOnly;
      },
      {"points.json", "on no ray"});
}

}  // namespace points_log_test
}  // namespace simuli
