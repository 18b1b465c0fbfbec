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

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/import/waymo/tfrecord.hpp"
#include "io/import/waymo/waymo_frame.hpp"
#include "io/log/new_log.hpp"

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

/// A segment on its way into a log's folder, record by record.
class SegmentLog {
 public:
  SegmentLog(const std::string& file, const fs::path& folder, WaymoReport& report)
      : file_(file), reader_(file), report_(report) {
    log_.folder = folder;
  }

  void add(const std::string& record) {
    const Frame frame = reader_.frame(record);
    if (frames_ == 0) begin(frame);
    for (const auto& [time_s, pose] : frame.poses) place(time_s, pose);
    if (frame.poses.empty()) place(frame.time_s, frame.world_from_vehicle);
    for (const Picture& p : frame.pictures) add_picture(p);
    if (!frame.top.empty()) add_sweep(frame);
    boxes_.add(frame, frame.time_s - origin_s_);
    ++frames_;
  }

  /// The whole log, in time's order.
  Log take() {
    report_.frames = frames_;
    end_sweeps();
    sort_by_time(log_);
    log_.actors = boxes_.take(file_);
    std::vector<TimedPose> poses;
    for (const auto& [ns, pose] : path_) poses.push_back({static_cast<double>(ns) * 1e-9, pose});
    log_.world_from_rig = Trajectory(std::move(poses));
    return std::move(log_);
  }

 private:
  void begin(const Frame& frame) {
    log_.name = name_from(frame.name);
    log_.start_ns = static_cast<std::int64_t>(std::llround(frame.time_s * 1e6)) * 1000;
    origin_s_ = static_cast<double>(log_.start_ns) * 1e-9;
    for (const std::string_view calibration : frame.cameras)
      log_.cameras.push_back(reader_.camera(calibration));
  }

  void place(double time_s, const Pose& pose) { path_[std::llround((time_s - origin_s_) * 1e9)] = pose; }

  void add_picture(const Picture& p) {
    const std::string name = reader_.camera_name(p.name);
    const std::string image = fmt::format("images/{}_{:06}.jpg", name, frames_);
    put_file(log_, image, [&](const fs::path& to) { write_file_atomically(to, std::string(p.bytes)); });
    const bool global = log_.camera(name).model.shutter == ShutterKind::kGlobal;
    const double middle_s = 0.5 * (p.start_s + p.end_s);
    log_.images.push_back({name,
                           image,
                           (global ? middle_s : p.start_s) - origin_s_,
                           (global ? middle_s : p.end_s) - origin_s_});
  }

  void add_sweep(const Frame& frame) {
    const Grid grid = reader_.grid(frame.top);
    for (const std::string_view calibration : frame.lidars) {
      LogLidar lidar;
      if (log_.lidars.empty() && reader_.lidar(calibration, grid.rows, grid.columns, lidar))
        log_.lidars = {lidar};
    }
    if (log_.lidars.empty()) throw_input_error(file_, "laser calibrations", "none of TOP", "one");
    const Lidar& model = log_.lidars[0].with_rows();
    if (grid.rows != model.rows.size() || grid.columns != static_cast<std::size_t>(model.columns)) {
      throw_input_error(file_, "range image", "another size than the first", "one size");
    }
    const Sweep sweep = sweep_of(grid, model);
    const std::string name = fmt::format("sweeps/{:06}.exr", frames_);
    put_sweep(log_, name, sweep);
    report_.rays += sweep.range.size();
    report_.returned += static_cast<std::size_t>(
        std::count_if(sweep.range.begin(), sweep.range.end(), [](float r) { return r > 0.0F; }));
    log_.sweeps.push_back({model.name, name, frame.time_s - origin_s_, 0.0});
  }

  /// A sweep ends where the next begins, or a turn later.
  void end_sweeps() {
    constexpr double kRevolution_s = 0.1;
    std::vector<SweepFrame>& sweeps = log_.sweeps;
    for (std::size_t i = 0; i < sweeps.size(); ++i) {
      const bool follows =
          i + 1 < sweeps.size() && sweeps[i + 1].time_start_s - sweeps[i].time_start_s < 1.5 * kRevolution_s;
      sweeps[i].time_end_s = follows ? sweeps[i + 1].time_start_s : sweeps[i].time_start_s + kRevolution_s;
    }
  }

  std::string file_;
  Reader reader_;
  WaymoReport& report_;
  Log log_;
  double origin_s_ = 0.0;              // of the log's times, since 1970
  std::map<std::int64_t, Pose> path_;  // by ns
  Boxes boxes_;
  std::size_t frames_ = 0;
};

}  // namespace

Log import_waymo(const WaymoOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress,
                 WaymoReport& report) {
  TfRecords records(options.segment);
  Log log;
  return make_import(options.output, log, [&] {
    SegmentLog segment(options.segment.string(), log.folder, report);
    std::string record;
    while (records.next(record)) {
      segment.add(record);
      if (progress)
        progress(static_cast<std::size_t>(records.at()), static_cast<std::size_t>(records.size()));
    }
    log = segment.take();
  });
}

}  // namespace simuli
