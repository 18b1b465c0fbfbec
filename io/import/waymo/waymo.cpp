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
#include "io/import/waymo/waymo_frame.hpp"
#include "io/log/new_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using namespace waymo;

constexpr std::array<const char*, 5> kLabelKinds{"unknown", "vehicle", "pedestrian", "sign", "cyclist"};
constexpr double kRevolution_s = 0.1;

/// Converts a segment to a log's folder, record by record.
class SegmentLog {
 public:
  SegmentLog(const std::string& file, Log& log, WaymoReport& report)
      : file_(file), reader_(file), log_(log), maker_(log, {}, 0), report_(report) {}

  void add(const std::string& record) {
    const Frame frame = reader_.frame(record);
    if (report_.frames == 0) begin(frame);
    for (const auto& [time_s, pose] : frame.poses) place(time_s, pose);
    if (frame.poses.empty()) place(frame.time_s, frame.world_from_vehicle);
    for (const Picture& p : frame.pictures) add_picture(p);
    if (!frame.top.empty()) add_sweep(frame);
    for (const Box& box : frame.boxes) add_box(frame, box);
    ++report_.frames;
  }

  void finish() {
    report_.rays = maker_.rays();
    report_.returned = maker_.returned();
    std::vector<double> starts_s;
    for (const SweepFrame& sweep : log_.sweeps) starts_s.push_back(sweep.time_start_s);
    const std::vector<FrameSpan> spans = sweep_spans(starts_s, kRevolution_s, SweepStamp::kStart);
    for (std::size_t i = 0; i < spans.size(); ++i) log_.sweeps[i].time_end_s = spans[i].time_end_s;
    log_.actors = labels_.take(file_, report_.labels);
    std::vector<TimedPose> poses;
    for (const auto& [ns, pose] : path_) poses.push_back({static_cast<double>(ns) * 1e-9, pose});
    log_.world_from_rig = Trajectory(std::move(poses));
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
    const std::string image = fmt::format("images/{}_{:06}.jpg", name, report_.frames);
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
    const double start_s = frame.time_s - origin_s_;
    maker_.add_sweep(
        model.name, fmt::format("{:06}", report_.frames), sweep_of(grid, model), {start_s, start_s});
  }

  void add_box(const Frame& frame, const Box& box) {
    const Pose vehicle_from_box{
        Eigen::Quaterniond(Eigen::AngleAxisd(box.values[7], Eigen::Vector3d::UnitZ())),
        {box.values[1], box.values[2], box.values[3]}};
    labels_.add(box.id,
                kLabelKinds.at(std::min<std::uint64_t>(box.type, 4)),
                {frame.time_s - origin_s_, frame.world_from_vehicle * vehicle_from_box},
                {box.values[5], box.values[4], box.values[6]});
  }

  std::string file_;
  Reader reader_;
  Log& log_;
  LogMaker maker_;
  WaymoReport& report_;
  double origin_s_ = 0.0;              // origin of the log's times, since 1970
  std::map<std::int64_t, Pose> path_;  // by ns
  LabelTracks labels_;
};

}  // namespace

Log import_waymo(const WaymoOptions& options, const FrameProgress& progress, WaymoReport& report) {
  TfRecords records(options.segment);
  report = {};
  Log log;
  return make_import(options.output, log, [&] {
    SegmentLog segment(options.segment.string(), log, report);
    std::string record;
    while (records.next(record)) {
      segment.add(record);
      if (progress)
        progress(static_cast<std::size_t>(records.at()), static_cast<std::size_t>(records.size()));
    }
    segment.finish();
  });
}

}  // namespace simuli
