#include "bench/drives/drive_rows.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>

#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::bench {
namespace {

/// A line of the table: one value, or two related values.
struct Line {
  const char* name;
  const char* key;
  double factor;
  int decimals;
  const char* second = nullptr;
  double second_factor = 1.0;
  int second_decimals = 0;
};
constexpr std::array kLines{
    Line{"PSNR dB / SSIM", "psnr_db", 1.0, 1, "ssim", 1.0, 2},
    Line{"FLIP", "flip", 1.0, 3},
    Line{"LiDAR distance error, median cm", "distance_median_m", 100.0, 1},
    Line{"MedL2, m2 / MeanRelL2", "medl2_m2", 1.0, 5, "mean_rel_l2", 1.0, 3},
    Line{"ray-drop decisions right / if every ray returned",
         "raydrop_accuracy",
         1.0,
         3,
         "raydrop_trivial",
         1.0,
         3},
    Line{"dropped rays found / drops that are right", "drop_recall", 1.0, 2, "drop_precision", 1.0, 2},
    Line{"Chamfer, m2 / mean of both ways, m", "chamfer_m2", 1.0, 3, "chamfer_m", 1.0, 2},
    Line{"intensity error, RMS of 1", "intensity_rmse", 1.0, 3},
    Line{"inside moving boxes: PSNR dB / median cm",
         "actor_psnr_db",
         1.0,
         1,
         "actor_distance_median_m",
         100.0,
         1},
    Line{"LiDAR set, thousands / MR/s", "lidar_particles", 1e-3, 0, "lidar_mr_per_s", 1.0, 1},
    Line{"camera set, thousands / MP/s", "camera_particles", 1e-3, 0, "camera_mp_per_s", 1.0, 1},
    Line{"iterations / training, min", "iterations", 1.0, 0, "train_s", 1.0 / 60.0, 1},
    Line{"processor time, start and end included, s", "processor_s", 1.0, 0}};

std::string number(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string cell(const DriveRow& row, const Line& line) {
  std::string text = number(line.factor * row.value(line.key), line.decimals);
  if (line.second != nullptr) {
    text += " / " + number(line.second_factor * row.value(line.second), line.second_decimals);
  }
  return text;
}

Json json_of(const DriveRow& row) {
  Json out = {
      {"drive", row.drive}, {"labels", row.labels}, {"frames", row.frames}, {"settings", row.settings}};
  for (const auto& [key, value] : row.values) out[key] = value;
  return out;
}

}  // namespace

double DriveRow::value(const std::string& key) const {
  for (const auto& [name, value] : values) {
    if (name == key) return value;
  }
  return kNoNumber;
}

std::string DriveRow::title() const { return labels ? drive + ", boxes of the log" : drive; }

std::vector<std::pair<std::string, double>> values_of(const EvalReport& r,
                                                      const TrainingReport& training,
                                                      double train_s,
                                                      double processor_s) {
  const TrainReport& t = training.train;
  const auto count = [](auto number) { return static_cast<double>(number); };
  return {{"images", count(r.images)},
          {"sweeps", count(r.sweeps)},
          {"image_width_px", r.image_width},
          {"image_height_px", r.image_height},
          {"psnr_db", r.psnr_db},
          {"ssim", r.ssim},
          {"flip", r.flip},
          {"distance_median_m", r.lidar.distance_median_m},
          {"medl2_m2", r.lidar.medl2_m2},
          {"mean_rel_l2", r.lidar.mean_rel_l2},
          {"raydrop_accuracy", r.lidar.raydrop_accuracy},
          {"raydrop_trivial", r.lidar.raydrop_trivial},
          {"drop_recall", r.lidar.drop_recall},
          {"drop_precision", r.lidar.drop_precision},
          {"chamfer_m", r.lidar.chamfer_m},
          {"chamfer_m2", r.lidar.chamfer_m2},
          {"intensity_rmse", r.lidar.intensity_rmse},
          {"actor_psnr_db", r.actor_psnr_db},
          {"actor_distance_median_m", r.actor_distance_median_m},
          {"actor_share_met", r.actor_share_met},
          {"lidar_particles", count(t.lidar_particles)},
          {"lidar_mr_per_s", r.lidar_mr_per_s},
          {"camera_particles", count(t.camera_particles)},
          {"camera_mp_per_s", r.camera_mp_per_s},
          {"iterations", t.last.iteration},
          {"init_s", training.init.seconds},
          {"train_s", training.init.seconds + train_s},
          {"processor_s", processor_s}};
}

std::string to_markdown(const std::vector<DriveRow>& rows) {
  const auto line = [&](const std::string& name, const std::function<std::string(const DriveRow&)>& cell_of) {
    std::string text = "| " + name + " |";
    for (const DriveRow& row : rows) text += fmt::format(" {} |", cell_of(row));
    return text + "\n";
  };
  std::string text = line("held-out frames", [](const DriveRow& row) {
    return fmt::format(
        "{}, {} x {} px", row.title(), row.value("image_width_px"), row.value("image_height_px"));
  });
  text += line("---", [](const DriveRow&) { return "---"; });
  for (const Line& of : kLines) {
    text += line(of.name, [&](const DriveRow& row) { return cell(row, of); });
  }
  text += line("held out: which, pictures + sweeps", [](const DriveRow& row) {
    return fmt::format("{}: {} + {}", row.frames, row.value("images"), row.value("sweeps"));
  });
  text += line("settings other than the defaults", [](const DriveRow& row) {
    return row.settings.empty() ? std::string("none") : fmt::format("`{}`", fmt::join(row.settings, " "));
  });
  return text;
}

std::string to_json(const std::vector<DriveRow>& rows) {
  Json out = Json::array();
  for (const DriveRow& row : rows) out.push_back(json_of(row));
  return out.dump(2) + '\n';
}

std::string to_line(const DriveRow& row) {
  std::string text = row.title() + ":";
  for (const Line& of : kLines) text += fmt::format(" {} {};", of.name, cell(row, of));
  return text;
}

void keep_row(const std::filesystem::path& file, const DriveRow& row, const std::string& identity) {
  const Json out = {{"identity", identity}, {"row", json_of(row)}};
  write_file_atomically(file, out.dump(2) + '\n');
}

std::optional<DriveRow> kept_row(const std::filesystem::path& file, const std::string& identity) {
  if (!std::filesystem::exists(file)) return {};
  return read_json_text(read_file(file), file.string(), [&](JsonObject& root) -> std::optional<DriveRow> {
    const bool same =
        root.get("identity") == Json(identity);  // a text of several lines, which text() rejects
    DriveRow row;
    root.object("row", [&](JsonObject& object) {
      row.drive = object.text("drive");
      row.labels = object.boolean("labels");
      row.frames = object.text("frames");
      for (const Json& line : object.get("settings")) row.settings.push_back(line.get<std::string>());
      for (const auto& [key, value] : values_of({}, {}, 0.0, 0.0)) {
        const bool known = object.has(key) && !object.get(key).is_null();
        row.values.emplace_back(key, known ? object.number(key) : kNoNumber);
      }
    });
    return same ? std::optional(std::move(row)) : std::nullopt;
  });
}

}  // namespace simuli::bench
