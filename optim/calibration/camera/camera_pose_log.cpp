// What the search for a camera's mounting reads of a log.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/calibration/camera/camera_pose.hpp"

namespace simuli::calibration {

double beam_spacing(const Lidar& lidar) {
  std::vector<double> gaps;
  for (std::size_t r = 1; r < lidar.rows.size(); ++r) {
    gaps.push_back(std::abs(lidar.rows[r].elevation - lidar.rows[r - 1].elevation));
  }
  return gaps.empty() ? lidar.azimuth_span / lidar.columns : upper_median(std::move(gaps));
}

namespace {

constexpr std::size_t kLeastViews = 16;  // that halves of a drive are worth comparing

/// Of one thing that is told twice.
template <class Vector>
void widen(Vector& sigma, const Eigen::Vector3d& apart) {
  sigma = sigma.cwiseMax(0.5 * apart.cwiseAbs());
}

/// Whether what was given lies within what the report says of its own errors.
bool is_as_given(const CameraPoseReport& report, const LogCamera& given) {
  constexpr double kTold = 2.0;  // standard deviations
  const MountingStep change =
      step_between({given.rig_from_camera, 0.0}, {report.rig_from_camera, report.time_offset_s});
  MountingStep sigma;
  sigma << report.translation_sigma_m, report.rotation_sigma_rad, report.time_sigma_s;
  return (change.cwiseAbs().array() <= kTold * sigma.array()).all();
}

/// What either half of the pictures says of the mounting, and to the pictures of the other one.
void ask_halves(std::vector<CameraView> views,
                const LogCamera& given,
                const Trajectory& world_from_rig,
                const LidarScene& scene,
                CameraPoseOptions options,
                const std::function<void(std::size_t, std::size_t)>& progress,
                CameraPoseReport& report) {
  constexpr double kWorse = 1.05;  // a right mounting that is found again is a little beside itself
  options.with_clock = false;      // what the whole says of it is believed
  for (CameraView& view : views) {
    view.exposure_start_s += report.time_offset_s;
    view.exposure_end_s += report.time_offset_s;
  }
  const auto middle = views.begin() + static_cast<std::ptrdiff_t>(views.size() / 2);
  const std::vector<CameraView> second(std::make_move_iterator(middle), std::make_move_iterator(views.end()));
  views.erase(middle, views.end());
  const std::array<const std::vector<CameraView>*, 2> halves{&views, &second};
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorKind::kNumeric,
                fmt::format("mounting of camera {}: not determined: {}", given.model.name, reason));
  };
  std::array<LogCamera, 2> by_half{given, given};
  for (std::size_t i = 0; i < 2; ++i) {
    with_context(i == 0 ? "asking the drive's first half" : "asking the drive's second half", [&] {
      by_half[i].rig_from_camera =
          find_camera_pose(*halves[i], given, world_from_rig, scene, options, progress).rig_from_camera;
    });
  }
  const MountingStep apart =
      step_between({by_half[0].rig_from_camera, 0.0}, {by_half[1].rig_from_camera, 0.0});
  report.halves_apart_m = apart.head<3>();
  report.halves_apart_rad = apart.segment<3>(3);
  widen(report.translation_sigma_m, *report.halves_apart_m);
  widen(report.rotation_sigma_rad, *report.halves_apart_rad);
  const double apart_m = report.halves_apart_m->lpNorm<Eigen::Infinity>();
  const double apart_rad = report.halves_apart_rad->lpNorm<Eigen::Infinity>();
  if (apart_m > 2.0 * kWorstTranslation_m || apart_rad > 2.0 * kWorstRotation_rad) {
    refuse(
        fmt::format("halves of the drive put it up to {:.3f} m and {:.2f} deg apart, allowed {:.3f} m and "
                    "{:.2f} deg, along and about each axis",
                    apart_m,
                    apart_rad / kDegree,
                    2.0 * kWorstTranslation_m,
                    2.0 * kWorstRotation_rad / kDegree));
  }
  if (is_as_given(report, given)) return;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::vector<CameraView>& other = *halves[1 - i];
    const double found_px = edges_apart_px(other, by_half[i], 0.0, world_from_rig, scene, options);
    const double given_px = edges_apart_px(other, given, 0.0, world_from_rig, scene, options);
    if (found_px > kWorse * given_px) {
      refuse(fmt::format(
          "what the {} half of the drive asks for puts depth edges {:.3f} px from those of the other "
          "half's pictures, allowed at most the {:.3f} px with what was given",
          i == 0 ? "first" : "second",
          found_px,
          given_px));
    }
  }
}

}  // namespace

void settle(const LogCamera& given, CameraPoseReport& report) {
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorKind::kNumeric,
                fmt::format("mounting of camera {}: not determined: {}", given.model.name, reason));
  };
  const double sigma_m = report.translation_sigma_m.maxCoeff(),
               sigma_rad = report.rotation_sigma_rad.maxCoeff();
  if (!(sigma_m <= kWorstTranslation_m && sigma_rad <= kWorstRotation_rad)) {
    refuse(fmt::format("standard deviations found {:.3f} m and {:.2f} deg, allowed {:.3f} m and {:.2f} deg",
                       sigma_m,
                       sigma_rad / kDegree,
                       kWorstTranslation_m,
                       kWorstRotation_rad / kDegree));
  }
  report.as_given = is_as_given(report, given);
  if (report.as_given) {
    report.rig_from_camera = given.rig_from_camera;
    report.time_offset_s = 0.0;
    report.notes.emplace_back("within two standard deviations of what was given, which is left as it is");
  } else if (report.after_px > report.before_px) {
    refuse(
        fmt::format("depth edges are {:.2f} px from the picture's with what was found, allowed at most the "
                    "{:.2f} px with what was given",
                    report.after_px,
                    report.before_px));
  }
}

CameraPoseReport find_camera_pose(const Log& log,
                                  const std::string& camera,
                                  const std::string& lidar,
                                  const Trajectory& world_from_rig,
                                  std::size_t most_views,
                                  const CameraPoseOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<const ImageFrame*> frames;
  for (const ImageFrame& frame : log.images) {
    if (frame.camera == camera) frames.push_back(&frame);
  }
  std::vector<CameraView> views;
  const std::size_t count = std::min(frames.size(), most_views);
  for (std::size_t i = 0; i < count; ++i) {
    const ImageFrame& frame = *frames[i * frames.size() / count];
    views.push_back(
        {Luminance(load_image(log, frame, log.camera(camera).model)), frame.time_start_s, frame.time_end_s});
  }
  const LogLidar& sensor = log.lidar(lidar);
  LidarScene scene;
  std::vector<Returns> sweeps;
  for (const SweepFrame& frame : log.sweeps) {
    if (frame.lidar != lidar) continue;
    const Sweep sweep = read_sweep(log, frame, sensor.model);
    const std::vector<DepthEdge> found = depth_edges(sweep, sensor, frame.time_start_s, frame.time_end_s);
    scene.edges.insert(scene.edges.end(), found.begin(), found.end());
    sweeps.push_back(returns_of(sweep, sensor, frame.time_start_s, frame.time_end_s));
  }
  std::stable_sort(scene.edges.begin(), scene.edges.end(), [](const DepthEdge& a, const DepthEdge& b) {
    return a.time_s < b.time_s;
  });
  scene.surfaces = surface_points(sweeps, world_from_rig);
  scene.spacing_rad = beam_spacing(sensor.with_rows());
  const bool has_halves = views.size() >= kLeastViews;
  // Of the whole's progress: searches that are done, and the current one, which may end early. Halves are asked
  // without a clock, which takes one pass.
  std::size_t before = 0, last = 0, last_total = 0, of_whole = 0;
  const auto tell = [&](std::size_t done, std::size_t total) {
    if (done <= last) before += last_total;
    if (before == 0) of_whole = total;
    last = done;
    last_total = total;
    const std::size_t of_all = has_halves ? (options.with_clock ? 2 : 3) * of_whole : of_whole;
    if (progress) progress(before + done, of_all);
  };
  const LogCamera& given = log.camera(camera);
  CameraPoseReport report = find_camera_pose(views, given, world_from_rig, scene, options, tell);
  if (has_halves) {
    ask_halves(std::move(views), given, world_from_rig, scene, options, tell, report);
  } else {
    report.notes.push_back(
        fmt::format("halves of the drive: found {} pictures, allowed {} and more: not compared",
                    views.size(),
                    kLeastViews));
  }
  settle(given, report);
  return report;
}

}  // namespace simuli::calibration
