#include "io/import/points/points_log.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/core/sensors/lidar_locate.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/points/firing_steps.hpp"
#include "io/import/points/unit_offset.hpp"
#include "io/log/log_json.hpp"
#include "io/log/new_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 6> kColumns{"x_m", "y_m", "z_m", "intensity", "row", "time_s"};

/// Positions of the known columns in a point; negative: missing.
struct Layout {
  std::size_t width = 0;
  std::array<int, kColumns.size()> at{-1, -1, -1, -1, -1, -1};
  bool in_world = false;
  // by LiDAR: modes of tables that are given without columns
  std::map<std::string, std::vector<LidarMode>> modes;
};

Layout read_layout(JsonObject& root) {
  Layout layout;
  const Json& names = root.get("point_columns");
  const auto refuse = [&](const std::string& found) {
    throw_input_error(root.file(),
                      "point_columns",
                      found,
                      "names, each once: x_m, y_m, z_m; intensity, row, time_s; others are skipped");
  };
  if (!names.is_array() || names.size() > 64) refuse("no array of at most 64");
  for (const Json& name : names) {
    if (!name.is_string()) refuse("no name");
    const auto known = std::find(kColumns.begin(), kColumns.end(), name.get<std::string>());
    if (known != kColumns.end()) {
      int& at = layout.at[static_cast<std::size_t>(known - kColumns.begin())];
      if (at >= 0) refuse(std::string(*known) + " twice");
      at = static_cast<int>(layout.width);
    }
    ++layout.width;
  }
  if (layout.at[0] < 0 || layout.at[1] < 0 || layout.at[2] < 0) refuse("no x_m, y_m or z_m");
  const std::string where = root.text("points_in");
  if (where != "sensor" && where != "world") {
    throw_input_error(root.file(), "points_in", '"' + where + '"', "sensor or world");
  }
  layout.in_world = where == "world";
  if (layout.in_world && layout.at[5] < 0) {
    throw_input_error(root.file(), "point_columns", "no time_s", "time_s, with points in the world");
  }
  return layout;
}

/// Returns the LiDAR of a named table as in log.json; other models unchanged.
Json whole_lidar(const std::string& file, const std::string& path, const Json& value, Layout& layout) {
  if (!value.is_object() || !value.contains("table")) return value;
  JsonObject object(file, path, value);
  return object.read_and_finish([&layout](JsonObject& o) {
    const std::string table = o.text("table");
    const std::vector<std::string> known = builtin_lidar_names();
    if (std::find(known.begin(), known.end(), table) == known.end()) {
      throw_input_error(o.file(), o.field("table"), '"' + table + '"', "a name of simuli info sensors");
    }
    LogLidar lidar;
    Lidar model = builtin_lidar(table);
    model.name = o.text("name");
    need_name(model.name, o.file(), o.field("name"));
    constexpr std::int64_t kMostColumns = 65536;
    if (!o.has("columns")) layout.modes[model.name] = builtin_lidar_with_facts(table).facts.modes;
    if (o.has("columns")) model.columns = static_cast<int>(o.integer("columns", 1, kMostColumns));
    if (o.has("azimuth_first_rad")) model.azimuth_first = o.number("azimuth_first_rad");
    if (o.has("spin")) {
      const bool clockwise = o.text("spin") == "clockwise";
      if (!clockwise && o.text("spin") != "counter_clockwise") {
        throw_input_error(
            o.file(), o.field("spin"), '"' + o.text("spin") + '"', "clockwise, counter_clockwise");
      }
      model.spin = clockwise ? SpinDirection::kClockwise : SpinDirection::kCounterClockwise;
    }
    validate(model, o.file());
    lidar.model = std::move(model);
    lidar.rig_from_lidar = o.object("rig_from_lidar", pose_from_json);
    return to_json(lidar);
  });
}

/// Returns the log that points.json describes, with file names relative to the folder.
Log read_description(const fs::path& folder, Layout& layout) {
  const fs::path path = folder / "points.json";
  const std::string file = path.string();
  Json json = parse_json(read_file(path), file);
  JsonObject root(file, "", json);
  root.ignore_other_keys();
  if (root.text("format") != "simuli points") {
    throw_input_error(file, "format", '"' + root.text("format") + '"', "\"simuli points\"");
  }
  layout = read_layout(root);
  Json log = json;
  log["format"] = "simuli log";
  log.erase("point_columns");
  log.erase("points_in");
  if (log.contains("lidars") && log["lidars"].is_array()) {
    for (std::size_t i = 0; i < log["lidars"].size(); ++i) {
      log["lidars"][i] = whole_lidar(file, fmt::format("lidars[{}]", i), log["lidars"][i], layout);
    }
  }
  JsonObject whole(file, "", log);
  return whole.read_and_finish([&](JsonObject& object) { return log_from_json(object, folder); });
}

/// Returns the points of a file; points in world coordinates are not converted yet.
std::vector<MeasuredPoint> read_points(const fs::path& file, const Layout& layout, const Lidar& lidar) {
  static_assert(std::endian::native == std::endian::little, "the files are little endian");
  const std::string bytes = read_file(file, std::size_t{1} << 30U);
  const std::size_t point_bytes = 4 * layout.width;
  if (bytes.size() % point_bytes != 0) {
    throw_input_error(file.string(),
                      "size",
                      fmt::format("{} bytes", bytes.size()),
                      fmt::format("a multiple of {} ({} columns)", point_bytes, layout.width));
  }
  std::vector<MeasuredPoint> points;
  for (std::size_t i = 0; i < bytes.size() / point_bytes; ++i) {
    const auto value = [&](std::size_t column, float other) {
      if (layout.at[column] < 0) return other;
      std::memcpy(
          &other, bytes.data() + i * point_bytes + 4 * static_cast<std::size_t>(layout.at[column]), 4);
      return other;
    };
    const auto need = [&](std::size_t column, float found, double low, double high) {
      if (found >= low && found <= high) return;
      throw_input_error(file.string(),
                        fmt::format("point {}: {}", i, kColumns[column]),
                        fmt::format("{}", found),
                        fmt::format("{} to {}", low, high));
    };
    constexpr double kFarthest_m = 1e5;
    MeasuredPoint point;
    for (std::size_t k = 0; k < 3; ++k) {
      const float x = value(k, 0.0F);
      need(k, x, -kFarthest_m, kFarthest_m);
      point.position[static_cast<Eigen::Index>(k)] = x;
    }
    point.intensity = value(3, 0.0F);
    need(3, point.intensity, 0.0, 1.0);
    if (layout.at[4] >= 0) {
      const float row = value(4, 0.0F);
      need(4, row, 0.0, lidar.row_count() - 1);
      point.row = static_cast<int>(row);
    }
    if (layout.at[5] >= 0) {
      const float time_s = value(5, 0.0F);
      need(5, time_s, -lidar.sweep_s, 2.0 * lidar.sweep_s);
      point.time_fraction = time_s / lidar.sweep_s;
    }
    points.push_back(point);
  }
  return points;
}

/// Converts points from world coordinates to the sensor's frame, each at its own time.
void put_into_sensor(std::vector<MeasuredPoint>& points, const SweepFrame& sweep, const Log& log) {
  const Pose& mount = log.lidar(sweep.lidar).rig_from_lidar;
  const double duration_s = sweep.time_end_s - sweep.time_start_s;
  for (MeasuredPoint& point : points) {
    const double time_s = sweep.time_start_s + std::clamp(point.time_fraction, 0.0, 1.0) * duration_s;
    point.position = (log.world_from_rig.at(time_s) * mount).inverse() * point.position;
  }
}

/// Fits the LiDAR's table to the first sweeps: elevation offset, columns, and firing pattern.
void fit_table(
    const PointsOptions& options, const Layout& layout, const Log& log, Lidar& lidar, PointReport& report) {
  constexpr std::size_t kSweeps = 4;
  std::vector<std::vector<MeasuredPoint>> sweeps;
  std::vector<Eigen::Vector3d> places;
  for (const SweepFrame& sweep : log.sweeps) {
    if (sweep.lidar != lidar.name || sweeps.size() == kSweeps) continue;
    lidar.sweep_s = sweep.time_end_s - sweep.time_start_s;
    sweeps.push_back(read_points(options.folder / sweep.file, layout, lidar));
    if (layout.in_world) put_into_sensor(sweeps.back(), sweep, log);
    for (const MeasuredPoint& point : sweeps.back()) places.push_back(point.position);
  }
  const auto note = [&](const std::string& text) {
    report.notes.push_back("LiDAR " + lidar.name + ": " + text);
  };
  const double offset = unit_offset(lidar, places);
  if (offset != 0.0) note(raise_beams(lidar, offset));
  std::vector<FiredRun> runs;
  const std::vector<double> tolerances = row_tolerances(lidar);
  for (const auto& sweep : sweeps) {
    std::vector<FiredRun> rows(lidar.rows.size());
    for (const MeasuredPoint& point : sweep) {
      const int row = point.row >= 0 ? point.row : nearest_row(lidar, tolerances, point.position);
      const auto hit = row < 0 ? std::nullopt : locate_in_row(lidar, row, point.position);
      if (hit) rows[static_cast<std::size_t>(row)].push_back(hit->azimuth);
    }
    std::move(rows.begin(), rows.end(), std::back_inserter(runs));
  }
  const auto modes = layout.modes.find(lidar.name);
  const double steps = modes == layout.modes.end() ? 0.0 : columns_by_steps(runs, lidar.azimuth_span);
  constexpr double kSame = 0.08, kThinned = 4.0;
  if (steps > 0.0 && std::abs(steps - lidar.columns) > kSame * lidar.columns &&
      steps * kThinned > lidar.columns && steps < kThinned * lidar.columns) {
    LidarMode mode{1.0 / lidar.sweep_s, static_cast<int>(std::lround(steps))};
    for (const LidarMode& known : modes->second) {
      if (std::abs(steps - known.columns) <= kSame * known.columns) mode.columns = known.columns;
    }
    note(fmt::format("{} columns, not {}, by the points", mode.columns, lidar.columns));
    lidar = in_mode(lidar, mode);
  }
  const int changed = set_firing_pattern(runs, lidar);
  if (changed > 0) note(fmt::format("{} beams fire in other columns than in the table", changed));
}

}  // namespace

Log import_points(const PointsOptions& options, const FrameProgress& progress, PointReport& report) {
  Layout layout;
  Log log = read_description(options.folder, layout);
  const fs::path source = options.folder / "points.json";
  for (LogLidar& lidar : log.lidars) {
    auto* const rows = std::get_if<Lidar>(&lidar.model);
    if (rows == nullptr) continue;
    Lidar fitted = *rows;
    fit_table(options, layout, log, fitted, report);
    fitted.sweep_s = rows->sweep_s;
    *rows = std::move(fitted);
  }
  return make_import(options.output, log, [&] {
    const std::vector<SweepFrame> sweeps = std::exchange(log.sweeps, {});
    const std::vector<ImageFrame> images = std::exchange(log.images, {});
    LogMaker maker(log, progress, images.size() + sweeps.size());
    for (std::size_t i = 0; i < sweeps.size(); ++i) {
      const SweepFrame& sweep = sweeps[i];
      Lidar lidar = log.lidar(sweep.lidar).with_rows();
      lidar.sweep_s = sweep.time_end_s - sweep.time_start_s;
      std::vector<MeasuredPoint> points = read_points(options.folder / sweep.file, layout, lidar);
      if (layout.in_world) put_into_sensor(points, sweep, log);
      maker.add_sweep(sweep.lidar,
                      fmt::format("{:06}", i),
                      grid_points(points, lidar, report),
                      {sweep.time_start_s, sweep.time_end_s});
      maker.step();
    }
    need_placed(report, source.string());
    for (std::size_t i = 0; i < images.size(); ++i) {
      maker.add_picture(log.camera(images[i].camera).model,
                        fmt::format("{:06}", i),
                        options.folder / images[i].file,
                        source.string(),
                        {images[i].time_start_s, images[i].time_end_s});
      maker.step();
    }
    const auto bring = [&](const std::string& file, const std::string& name) {
      put_file(log, name, [&](const fs::path& to) {
        write_file_atomically(to, read_file(options.folder / file));
      });
    };
    for (const LogMask& mask : log.masks) bring(mask.file, mask.file);
    if (!log.points.empty()) bring(std::exchange(log.points, "points.ply"), "points.ply");
  });
}

}  // namespace simuli
