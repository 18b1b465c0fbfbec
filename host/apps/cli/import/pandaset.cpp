#include "io/import/pandaset/pandaset.hpp"

#include <fmt/format.h>
#include <memory>
#include <string>

#include "host/apps/cli/import/run_import.hpp"
#include "host/core/base/angles.hpp"

namespace simuli::cli {
namespace {

std::vector<std::string> print_pandaset(const PandasetReport& r) {
  std::vector<std::string> lines;
  for (const PandasetGap& gap : r.gaps) {
    lines.push_back(fmt::format("{}: nothing recorded in {} of the frames: {}",
                                gap.sensor,
                                gap.frames.size(),
                                runs_text(gap.frames)));
  }
  for (const PandasetMount& mount : r.mounts) {
    lines.push_back(
        fmt::format("{}: poses of {} pictures differ by {:.1f} mm and {:.3f} degrees from one mounting (RMS)",
                    mount.camera,
                    mount.poses,
                    1e3 * mount.off_m,
                    mount.off_rad / kDegree));
  }
  lines.insert(lines.end(), r.hidden.begin(), r.hidden.end());
  if (r.points.points > 0) {
    lines.push_back(fmt::format("pandar64: spins {}clockwise, agreement {:.3f}; {}",
                                r.is_clockwise ? "" : "counter-",
                                r.spin_agreement,
                                points_line(r.points)));
    const Pose& off = r.mounting.table_from_sensor;
    lines.push_back(
        fmt::format("pandar64: {:.1f} cm and {:.3f} degrees from the published mounting; its points are "
                    "{:.3f} degrees from its beams, {:.3f} before",
                    100.0 * off.translation.norm(),
                    off.rotation.angularDistance(Eigen::Quaterniond::Identity()) / kDegree,
                    r.mounting.left_rad / kDegree,
                    r.mounting.before_rad / kDegree));
  }
  if (r.list_rays > 0) {
    lines.push_back(
        fmt::format("pandargt: {} points as sweeps of {} rays, all returned; {} rays repeat a point "
                    "to fill the sweeps; left out: {} sweeps that another frame contains",
                    r.list_points,
                    r.list_rays,
                    r.list_repeated,
                    r.list_again));
  }
  lines.push_back(
      fmt::format("{} boxes; left out: {} of the second LiDAR that repeat boxes of the first; {} without a "
                  "point, timed by the front camera",
                  r.labels.kept,
                  r.boxes_twice,
                  r.boxes_by_front));
  return lines;
}

}  // namespace

void add_import_pandaset(Command import, const Globals& globals) {
  const auto options = std::make_shared<PandasetOptions>();
  Command sub = import.command("pandaset", "a sequence of PandaSet: cameras, Pandar64, PandarGT, boxes");
  sub.option("DIR", options->sequence, "folder of one sequence: camera, lidar, annotations").required();
  sub.option("--cameras", options->cameras, "comma-separated cameras to import")
      .comma_separated()
      .shown_as("NAME,...", "all");
  sub.option("--lidars", options->lidars, "comma-separated list of pandar64 and pandargt")
      .comma_separated()
      .shown_as("NAME,...", "both");
  add_frames(sub, options, "the sequence's");
  add_run<PandasetReport>(sub, "pandaset", options, globals, import_pandaset, print_pandaset);
}

}  // namespace simuli::cli
