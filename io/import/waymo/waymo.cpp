#include "io/import/waymo/waymo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/waymo/tfrecord.hpp"
#include "io/import/waymo/waymo_frame.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace waymo;

constexpr std::array<const char*, 5> kLabelKinds{"unknown", "vehicle", "pedestrian", "sign", "cyclist"};

/// Boxes of all frames, one actor per id.
class Boxes {
 public:
  void add(const Frame& frame, double time_s) {
    for (const Box& b : frame.boxes) {
      const std::string kind = kLabelKinds.at(std::min<std::uint64_t>(b.type, 4));
      const auto [entry, is_new] = index_.emplace(b.id, actors_.size());
      if (is_new) {
        actors_.push_back(
            {fmt::format("{}_{}", kind, actors_.size()), kind, {b.values[5], b.values[4], b.values[6]}, {}});
      }
      const Pose vehicle_from_box{
          Eigen::Quaterniond(Eigen::AngleAxisd(b.values[7], Eigen::Vector3d::UnitZ())),
          {b.values[1], b.values[2], b.values[3]}};
      actors_[entry->second].track.push_back({time_s, frame.world_from_vehicle * vehicle_from_box});
    }
  }
  [[nodiscard]] std::vector<Actor> take(const std::string& file) {
    for (const Actor& actor : actors_) validate(actor, file);
    return std::move(actors_);
  }

 private:
  std::vector<Actor> actors_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

Log import_waymo(const WaymoOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress,
                 WaymoReport& report) {
  const std::string file = options.segment.string();
  const Reader reader(file);
  TfRecords records(options.segment);
  Log log, written;
  std::map<std::int64_t, Pose> path;
  std::vector<double> starts_s;  // of the frames, since 1970
  Boxes boxes;
  write_folder_atomically(options.output, [&](const fs::path& folder) {
    log.folder = folder;
    fs::create_directory(folder / "images");
    fs::create_directory(folder / "sweeps");
    std::string record;
    while (records.next(record)) {
      const Frame frame = reader.frame(record);
      if (starts_s.empty()) {
        log.name = frame.name;
        log.start_ns = static_cast<std::int64_t>(std::llround(frame.time_s * 1e6)) * 1000;
        for (const std::string_view calibration : frame.cameras)
          log.cameras.push_back(reader.camera(calibration));
      }
      const double origin_s = static_cast<double>(log.start_ns) * 1e-9;
      const auto place = [&](double time_s, const Pose& pose) {
        path[std::llround((time_s - origin_s) * 1e9)] = pose;
      };
      for (const auto& [time_s, pose] : frame.poses) place(time_s, pose);
      if (frame.poses.empty()) place(frame.time_s, frame.world_from_vehicle);
      for (const Picture& p : frame.pictures) {
        const std::string name = reader.camera_name(p.name);
        const std::string image = fmt::format("images/{}_{:06}.jpg", name, starts_s.size());
        write_file_atomically(folder / image, std::string(p.bytes));
        const bool global = log.camera(name).model.shutter == ShutterKind::kGlobal;
        const double middle_s = 0.5 * (p.start_s + p.end_s);
        log.images.push_back({name,
                              image,
                              (global ? middle_s : p.start_s) - origin_s,
                              (global ? middle_s : p.end_s) - origin_s});
      }
      if (!frame.top.empty()) {
        const Grid grid = reader.grid(frame.top);
        for (const std::string_view calibration : frame.lidars) {
          LogLidar lidar;
          if (log.lidars.empty() && reader.lidar(calibration, grid.rows, grid.columns, lidar))
            log.lidars = {lidar};
        }
        if (log.lidars.empty()) throw_input_error(file, "laser calibrations", "none of TOP", "one");
        const Lidar& model = log.lidars[0].with_rows();
        if (grid.rows != model.rows.size() || grid.columns != static_cast<std::size_t>(model.columns)) {
          throw_input_error(file, "range image", "another size than the first", "one size");
        }
        const Sweep sweep = sweep_of(grid, model);
        const std::string name = fmt::format("sweeps/{:06}.exr", starts_s.size());
        write_sweep(folder / name, sweep);
        report.rays += sweep.range.size();
        report.returned += static_cast<std::size_t>(
            std::count_if(sweep.range.begin(), sweep.range.end(), [](float r) { return r > 0.0F; }));
        log.sweeps.push_back({model.name, name, frame.time_s - origin_s, 0.0});
      }
      boxes.add(frame, frame.time_s - origin_s);
      starts_s.push_back(frame.time_s);
      if (progress)
        progress(static_cast<std::size_t>(records.at()), static_cast<std::size_t>(records.size()));
    }
    report.frames = starts_s.size();
    constexpr double kTurn_s = 0.1;
    for (std::size_t i = 0; i < log.sweeps.size(); ++i) {
      const bool follows = i + 1 < log.sweeps.size() &&
                           log.sweeps[i + 1].time_start_s - log.sweeps[i].time_start_s < 1.5 * kTurn_s;
      log.sweeps[i].time_end_s =
          follows ? log.sweeps[i + 1].time_start_s : log.sweeps[i].time_start_s + kTurn_s;
    }
    std::stable_sort(log.images.begin(), log.images.end(), [](const ImageFrame& a, const ImageFrame& b) {
      return a.time_start_s < b.time_start_s;
    });
    log.actors = boxes.take(file);
    std::vector<TimedPose> poses;
    for (const auto& [ns, pose] : path) poses.push_back({static_cast<double>(ns) * 1e-9, pose});
    log.world_from_rig = Trajectory(std::move(poses));
    write_log(log);
    written = read_log(folder);  // what was written is what the next command will read
  });
  written.folder = options.output;
  return written;
}

}  // namespace simuli
