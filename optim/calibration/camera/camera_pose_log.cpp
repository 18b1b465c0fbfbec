// Reads the inputs of the mounting search from a log.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <string>
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

constexpr std::size_t kLeastViews = 16;  // that comparing halves of a drive needs

[[noreturn]] void refuse(const LogCamera& given, const std::string& reason) {
  throw Error(ErrorKind::kNumeric,
              fmt::format("mounting of camera {}: not determined: {}", given.model.name, reason));
}

/// Combines two estimates of one quantity.
template <class Vector>
void widen(Vector& sigma, const Eigen::Vector3d& apart) {
  sigma = sigma.cwiseMax(0.5 * apart.cwiseAbs());
}

/// Whether the given values are within the reported errors.
bool is_as_given(const CameraPoseReport& report, const LogCamera& given) {
  constexpr double kReported = 2.0;  // standard deviations
  const MountingStep change =
      step_between({given.rig_from_camera, 0.0}, {report.rig_from_camera, report.time_offset_s});
  MountingStep sigma;
  sigma << report.translation_sigma_m, report.rotation_sigma_rad, report.time_sigma_s;
  return (change.cwiseAbs().array() <= kReported * sigma.array()).all();
}

/// Estimates the mounting from each half of the pictures and tests it on the other half.
void ask_halves(std::vector<CameraView> views,
                const LogCamera& given,
                const Trajectory& world_from_rig,
                const LidarScene& scene,
                CameraPoseOptions options,
                const std::function<void(std::size_t, std::size_t)>& progress,
                CameraPoseReport& report) {
  options.with_clock = report.time_known;  // a clock undetermined by all data is undetermined by halves
  const auto middle = views.begin() + static_cast<std::ptrdiff_t>(views.size() / 2);
  const std::vector<CameraView> second(std::make_move_iterator(middle), std::make_move_iterator(views.end()));
  views.erase(middle, views.end());
  const std::array<const std::vector<CameraView>*, 2> halves{&views, &second};
  std::array<Mounting, 2> by_half;
  for (std::size_t i = 0; i < 2; ++i) {
    with_context(i == 0 ? "asking the drive's first half" : "asking the drive's second half", [&] {
      const CameraPoseReport half =
          find_camera_pose(*halves[i], given, world_from_rig, scene, options, progress);
      by_half[i] = {half.rig_from_camera, half.time_offset_s};
    });
  }
  const MountingStep apart = step_between(by_half[0], by_half[1]);
  report.halves_apart_m = apart.head<3>();
  report.halves_apart_rad = apart.segment<3>(3);
  widen(report.translation_sigma_m, *report.halves_apart_m);
  widen(report.rotation_sigma_rad, *report.halves_apart_rad);
  const double apart_m = report.halves_apart_m->lpNorm<Eigen::Infinity>();
  const double apart_rad = report.halves_apart_rad->lpNorm<Eigen::Infinity>();
  if (apart_m > 2.0 * kWorstTranslation_m || apart_rad > 2.0 * kWorstRotation_rad) {
    refuse(given,
           fmt::format("halves of the drive put it up to {:.3f} m and {:.2f} deg apart, allowed {:.3f} m and "
                       "{:.2f} deg, along and about each axis",
                       apart_m,
                       apart_rad / kDegree,
                       2.0 * kWorstTranslation_m,
                       2.0 * kWorstRotation_rad / kDegree));
  }
  if (is_as_given(report, given)) return;
  for (std::size_t i = 0; i < 2; ++i) {
    const char* whose = i == 0 ? "the first half of the drive" : "the second half of the drive";
    need_better(*halves[1 - i], given, by_half[i], whose, world_from_rig, scene, options);
  }
}

}  // namespace

void need_better(const std::vector<CameraView>& views,
                 const LogCamera& given,
                 const Mounting& found,
                 const std::string& whose,
                 const Trajectory& world_from_rig,
                 const LidarScene& scene,
                 const CameraPoseOptions& options) {
  const std::array<Mounting, 2> mountings{found, Mounting{given.rig_from_camera, 0.0}};
  const auto edges_px = edges_apart_px(views, given, mountings, world_from_rig, scene, options);
  const auto texture =
      texture_of(views, given.model, world_from_rig, scene.surfaces, scene.spacing_rad, mountings);
  std::vector<std::string> against;
  if (!(edges_px[0] < edges_px[1])) {
    against.push_back(
        fmt::format("depth edges {:.3f} px from theirs, allowed below the {:.3f} px with what was given",
                    edges_px[0],
                    edges_px[1]));
  }
  if (texture && !((*texture)[0] > (*texture)[1])) {
    against.push_back(fmt::format("correlation of texture {:.3f}, allowed above {:.3f} with what was given",
                                  (*texture)[0],
                                  (*texture)[1]));
  }
  if (against.empty()) return;
  refuse(
      given,
      fmt::format("pictures that {} did not use contradict its result: {}", whose, fmt::join(against, "; ")));
}

void settle(const LogCamera& given, CameraPoseReport& report) {
  const double sigma_m = report.translation_sigma_m.maxCoeff(),
               sigma_rad = report.rotation_sigma_rad.maxCoeff();
  if (!(sigma_m <= kWorstTranslation_m && sigma_rad <= kWorstRotation_rad)) {
    refuse(given,
           fmt::format("standard deviations found {:.3f} m and {:.2f} deg, allowed {:.3f} m and {:.2f} deg",
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
        given,
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
  // Progress over all searches: completed ones and the current one, which may end early. Halves without clock
  // take one pass instead of two.
  std::size_t before = 0, last = 0, of_whole = 0;
  const auto tell = [&](std::size_t done, std::size_t total) {
    if (done <= last) before += of_whole;
    if (before == 0) of_whole = total;
    last = done;
    if (progress) progress(before + done * of_whole / total, (has_halves ? 3 : 1) * of_whole);
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
    if (!is_as_given(report, given)) refuse(given, report.notes.back());
  }
  settle(given, report);
  return report;
}

}  // namespace simuli::calibration
