// Tests the estimation of mountings and clocks with the analytic street.
#include "optim/calibration/camera/camera_pose.hpp"

#include <gtest/gtest.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/log/camera_mask.hpp"
#include "optim/base/frames.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/scratch.hpp"
#include "tests/optim/calibration/street_drive.hpp"

namespace simuli::calibration {
namespace {

struct Recording {
  std::vector<CameraView> views;
  LidarScene scene;
};

Image picture_of(const test::StreetDrive& drive, const LogCamera& camera, const ImageFrame& frame) {
  return render_street(drive.street, camera, drive.log.world_from_rig, frame.time_start_s, frame.time_end_s);
}

/// Records pictures, depth edges and surfaces of a drive; the pictures' recorded times are early by
/// clock_error_s.
Recording record(const test::StreetDrive& drive, double clock_error_s) {
  Recording out;
  const Log& log = drive.log;
  std::vector<Returns> sweeps;
  for (std::size_t i = 0; i < log.images.size(); ++i) {
    const ImageFrame& frame = log.images[i];
    out.views.push_back({Luminance(picture_of(drive, log.cameras[0], frame)),
                         frame.time_start_s - clock_error_s,
                         frame.time_end_s - clock_error_s});
    const SweepFrame& frame_of_sweep = log.sweeps[i];
    const Sweep sweep = drive.sweep(i);
    const std::vector<DepthEdge> found =
        depth_edges(sweep, log.lidars[0], frame_of_sweep.time_start_s, frame_of_sweep.time_end_s);
    out.scene.edges.insert(out.scene.edges.end(), found.begin(), found.end());
    sweeps.push_back(
        returns_of(sweep, log.lidars[0], frame_of_sweep.time_start_s, frame_of_sweep.time_end_s));
  }
  std::stable_sort(out.scene.edges.begin(),
                   out.scene.edges.end(),
                   [](const DepthEdge& a, const DepthEdge& b) { return a.time_s < b.time_s; });
  out.scene.surfaces = surface_points(sweeps, log.world_from_rig);
  out.scene.spacing_rad = beam_spacing(log.lidars[0].with_rows());
  return out;
}

/// Returns the camera with an error of 5 cm and 1 degree.
LogCamera misplaced(const LogCamera& camera) {
  LogCamera out = camera;
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -1.0, 0.7).normalized();
  out.rig_from_camera = camera.rig_from_camera * Pose{Eigen::Quaterniond(Eigen::AngleAxisd(kDegree, axis)),
                                                      0.05 * Eigen::Vector3d(0.6, 0.5, -0.62).normalized()};
  return out;
}

TEST(CameraPose, IsWonBackWithTheClock) {
  const test::StreetDrive drive(20, 8.0, 0.6, 400);
  const LogCamera& truth = drive.log.cameras[0];
  const Recording recording = record(drive, 0.02);
  const CameraPoseReport report =
      find_camera_pose(recording.views, misplaced(truth), drive.log.world_from_rig, recording.scene);
  const Pose off = truth.rig_from_camera.inverse() * report.rig_from_camera;
  EXPECT_LT(off.translation.norm(), 0.005) << off.translation.transpose();
  EXPECT_LT(off.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.05 * kDegree);
  EXPECT_TRUE(report.time_known);
  EXPECT_NEAR(report.time_offset_s, 0.02, 0.001);
  EXPECT_LT(report.after_px, report.before_px);
  EXPECT_GT(report.pieces, 500U);
  EXPECT_GT(report.texture_after, report.texture_before);
  // The standard deviations are valid: no error exceeds three of them, and they are small.
  Mounting real{truth.rig_from_camera, 0.02};
  const MountingStep error = step_between(real, {report.rig_from_camera, report.time_offset_s});
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(error[k]), 3.0 * report.translation_sigma_m[k]) << k;
    EXPECT_LT(std::abs(error[3 + k]), 3.0 * report.rotation_sigma_rad[k]) << k;
  }
  EXPECT_LT(std::abs(error[6]), 3.0 * report.time_sigma_s);
  EXPECT_LT(report.translation_sigma_m.maxCoeff(), 0.01);
  EXPECT_LT(report.rotation_sigma_rad.maxCoeff(), 0.05 * kDegree);
  EXPECT_NEAR(report.rotation_change_rad, kDegree, 0.05 * kDegree);
}

TEST(CameraPose, AtConstantSpeedTheClockIsUndetermined) {
  // At constant speed a delay of 20 ms equals a shift of 16 cm ahead.
  test::StreetDrive drive(8, 8.0, 0.0);
  drive.log.world_from_rig = Trajectory({{-0.3, {Eigen::Quaterniond::Identity(), {2.0, -1.75, 0.0}}},
                                         {1.2, {Eigen::Quaterniond::Identity(), {14.0, -1.75, 0.0}}}});
  const Recording recording = record(drive, 0.0);
  const CameraPoseReport report =
      find_camera_pose(recording.views, drive.log.cameras[0], drive.log.world_from_rig, recording.scene);
  EXPECT_FALSE(report.time_known);
  EXPECT_EQ(report.time_offset_s, 0.0);
  ASSERT_FALSE(report.notes.empty());
  EXPECT_NE(report.notes.front().find("constant speed"), std::string::npos) << report.notes.front();
  // The mounting is still determined.
  EXPECT_LT(report.translation_change_m.norm(), 0.06) << report.translation_change_m.transpose();
}

TEST(CameraPose, ABlankWallIsRefused) {
  const test::StreetDrive drive(3, 8.0, 0.3);
  Recording recording = record(drive, 0.0);
  for (CameraView& view : recording.views) view.picture = Luminance(Image(320, 180, 3));
  try {
    (void)find_camera_pose(recording.views, drive.log.cameras[0], drive.log.world_from_rig, recording.scene);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNumeric);
    EXPECT_NE(std::string(error.what()).find("not determined, found 0 depth edges"), std::string::npos)
        << error.what();
  }
}

/// Returns the drive's log with its pictures and sweeps written.
Log written(const test::StreetDrive& drive, const test::Scratch& scratch) {
  Log log = drive.log;
  log.folder = scratch / "log";
  for (std::size_t i = 0; i < log.images.size(); ++i) {
    std::filesystem::create_directories((log.folder / log.images[i].file).parent_path());
    std::filesystem::create_directories((log.folder / log.sweeps[i].file).parent_path());
    write_image(log.folder / log.images[i].file, picture_of(drive, log.cameras[0], log.images[i]));
    write_sweep(log.folder / log.sweeps[i].file, drive.sweep(i));
  }
  return log;
}

/// Adds a mask that hides the left eighth of each picture.
void mask_pillar(Log& log) {
  const Camera& camera = log.cameras[0].model;
  CameraMask mask{camera.width, camera.height, {}};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) mask.hidden.push_back(x < camera.width / 8 ? 1 : 0);
  }
  log.hidden[camera.name] = std::make_shared<const CameraMask>(mask);
}

/// Paints stripes of this width over the masked area.
void paint_pillar(const Log& log, int stripes_px) {
  for (const ImageFrame& frame : log.images) {
    Image picture = read_image(log.folder / frame.file);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width / 8; ++x) {
        const bool bright = (y / stripes_px + x / (2 * stripes_px)) % 2 == 0;
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = bright ? 1.0F : 0.0F;
      }
    }
    write_image(log.folder / frame.file, picture);
  }
}

CameraPoseReport pose_in(const Log& log) {
  CameraPoseOptions options;
  options.with_clock = false;
  return find_camera_pose(
      log, log.cameras[0].model.name, name_of(log.lidars[0].model), log.world_from_rig, 60, options);
}

TEST(CameraPose, WhatAMaskHidesMakesNoDifference) {
  const test::StreetDrive drive(8, 8.0, 0.6, 400);
  const test::Scratch scratch;
  const auto same_bits = [](const CameraPoseReport& a, const CameraPoseReport& b) {
    return a.rig_from_camera.translation == b.rig_from_camera.translation &&
           a.rig_from_camera.rotation.coeffs() == b.rig_from_camera.rotation.coeffs() &&
           a.time_offset_s == b.time_offset_s && a.translation_sigma_m == b.translation_sigma_m &&
           a.rotation_sigma_rad == b.rotation_sigma_rad && a.time_sigma_s == b.time_sigma_s &&
           a.edges == b.edges && a.matched == b.matched && a.pieces == b.pieces &&
           a.texture_points == b.texture_points && a.texture_after == b.texture_after &&
           a.after_px == b.after_px;
  };
  Log log = written(drive, scratch);
  mask_pillar(log);
  paint_pillar(log, 24);
  Recording recording = record(drive, 0.0);
  const auto pose_in_pictures = [&] {
    for (std::size_t i = 0; i < log.images.size(); ++i)
      recording.views[i].picture = Luminance(load_image(log, log.images[i], log.cameras[0].model));
    return find_camera_pose(recording.views, log.cameras[0], log.world_from_rig, recording.scene);
  };
  const CameraPoseReport report = pose_in_pictures();
  EXPECT_GT(report.pieces, 50U);
  EXPECT_LT(report.translation_change_m.norm(), 0.02) << report.translation_change_m.transpose();
  paint_pillar(log, 5);
  EXPECT_TRUE(same_bits(report, pose_in_pictures()));
  log.hidden.clear();
  const CameraPoseReport open = pose_in_pictures();
  EXPECT_FALSE(same_bits(report, open));
  EXPECT_GT(open.edges, report.edges);
}

TEST(CameraPose, IsToldTwiceByTheHalvesOfADrive) {
  const test::StreetDrive drive(16, 8.0, 0.6, 400);
  const test::Scratch scratch;
  Log log = written(drive, scratch);
  const LogCamera truth = log.cameras[0];
  log.cameras[0] = misplaced(truth);
  const CameraPoseReport report = pose_in(log);
  EXPECT_FALSE(report.as_given);
  const Pose off = truth.rig_from_camera.inverse() * report.rig_from_camera;
  EXPECT_LT(off.translation.norm(), 0.01) << off.translation.transpose();
  EXPECT_LT(off.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.1 * kDegree);
  ASSERT_TRUE(report.halves_apart_m && report.halves_apart_rad);
  EXPECT_LT(report.halves_apart_rad->norm(), 0.2 * kDegree);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GE(report.translation_sigma_m[k], 0.5 * std::abs((*report.halves_apart_m)[k]));
    EXPECT_GE(report.rotation_sigma_rad[k], 0.5 * std::abs((*report.halves_apart_rad)[k]));
  }
  // Pictures of each half from a camera rotated by these angles.
  const auto refuse_turned = [&](double first_deg, double second_deg, const char* reason) {
    for (std::size_t i = 0; i < log.images.size(); ++i) {
      const double angle = (i < log.images.size() / 2 ? first_deg : second_deg) * kDegree;
      LogCamera turned = truth;
      turned.rig_from_camera.rotation =
          turned.rig_from_camera.rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY());
      write_image(log.folder / log.images[i].file, picture_of(drive, turned, log.images[i]));
    }
    expect_error(ErrorKind::kNumeric, reason, [&] { (void)pose_in(log); });
  };
  refuse_turned(0.0, 1.0, "halves of the drive put it");
  // The halves roughly agree, but the first half's result is farther from the second half than the given
  // mounting.
  log.cameras[0] = truth;
  refuse_turned(0.3, 0.14, "pictures that the first half of the drive did not use contradict");
}

TEST(CameraPose, IsJudgedByPicturesThatItHasNotSeen) {
  const test::StreetDrive drive(8, 8.0, 0.6, 400);
  const Recording recording = record(drive, 0.0);
  const LogCamera& truth = drive.log.cameras[0];
  const Mounting right{truth.rig_from_camera, 0.0};
  const auto judge = [&](const LogCamera& given, const Mounting& found) {
    need_better(recording.views, given, found, "nobody", drive.log.world_from_rig, recording.scene);
  };
  judge(misplaced(truth), right);
  // Mountings that differ from the truth by little, by more, and in time.
  MountingStep step = MountingStep::Zero();
  step[4] = 0.1 * kDegree;
  for (const Mounting& beside :
       {moved(right, step), moved(right, 5.0 * step), Mounting{truth.rig_from_camera, 0.02}}) {
    expect_error(ErrorKind::kNumeric, "pictures that nobody did not use contradict", [&] {
      judge(truth, beside);
    });
  }
  // Only contradictions are reported: edges are nearer.
  LogCamera given = truth;
  given.rig_from_camera = moved(right, 4.2 * step).rig_from_camera;
  expect_error(ErrorKind::kNumeric, "result: correlation of texture", [&] {
    judge(given, Mounting{truth.rig_from_camera, 0.02});
  });
  // If edges do not determine the mounting, texture is used.
  const auto texture = [&](const Mounting& mounting) {
    return texture_of(recording.views,
                      truth.model,
                      drive.log.world_from_rig,
                      recording.scene.surfaces,
                      recording.scene.spacing_rad,
                      {right, mounting});
  };
  const auto apart = texture({misplaced(truth).rig_from_camera, 0.0});
  ASSERT_TRUE(apart);
  EXPECT_GT((*apart)[0], (*apart)[1] + 0.1);
  EXPECT_EQ((*texture(right))[0], (*texture(right))[1]);
}

TEST(CameraPose, WhatWasGivenStandsUnlessPicturesSayOtherwise) {
  const LogCamera given{.model = {"front", 320, 180, 200.0, 200.0, 160.0, 90.0},
                        .rig_from_camera = {Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1.0, 0.2, 1.5}}};
  struct Case {
    const char* what;
    Eigen::Vector3d moved_m, turned_deg;
    double late_s, before_px, after_px;
    bool stands, refused;
  };
  // Standard deviations: 1 cm, 0.05 degrees, 1 ms.
  const Case cases[] = {
      {"nothing", {0, 0, 0}, {0, 0, 0}, 0, 0.8, 0.8, true, false},
      {"a little on each axis", {0.019, -0.019, 0.019}, {0.09, -0.09, 0.09}, -0.0019, 0.8, 0.8, true, false},
      {"a little, and worse", {0.015, 0, 0}, {0, 0.09, 0}, 0, 0.8, 0.9, true, false},
      {"along one axis", {0, -0.021, 0}, {0, 0, 0}, 0, 0.8, 0.7, false, false},
      {"about one axis", {0, 0, 0}, {0, 0, -0.11}, 0, 0.8, 0.7, false, false},
      {"the clock", {0, 0, 0}, {0, 0, 0}, 0.0021, 0.8, 0.7, false, false},
      {"far, no better and no worse", {0.05, 0, 0}, {0, 0, 0}, 0, 0.8, 0.8, false, false},
      {"far and worse", {0.043, 0, 0}, {0.3, 0, 0}, 0, 0.79, 0.88, false, true},
      {"the clock, and worse", {0, 0, 0}, {0, 0, 0}, 0.02, 0.79, 0.8, false, true}};
  for (const Case& c : cases) {
    CameraPoseReport report;
    const Eigen::Vector3d turn = c.turned_deg * kDegree;
    const Mounting found =
        moved({given.rig_from_camera, 0.0}, (MountingStep() << c.moved_m, turn, c.late_s).finished());
    report.rig_from_camera = found.rig_from_camera;
    report.time_offset_s = found.time_offset_s;
    report.translation_sigma_m.setConstant(0.01);
    report.rotation_sigma_rad.setConstant(0.05 * kDegree);
    report.time_sigma_s = 1e-3;
    report.before_px = c.before_px;
    report.after_px = c.after_px;
    if (c.refused) {
      expect_error(ErrorKind::kNumeric, "allowed at most the 0.79 px with what was given", [&] {
        settle(given, report);
      });
      continue;
    }
    settle(given, report);
    EXPECT_EQ(report.as_given, c.stands) << c.what;
    const Pose& taken = c.stands ? given.rig_from_camera : found.rig_from_camera;
    EXPECT_EQ(report.rig_from_camera.translation, taken.translation) << c.what;
    EXPECT_EQ(report.rig_from_camera.rotation.coeffs(), taken.rotation.coeffs()) << c.what;
    EXPECT_EQ(report.time_offset_s, c.stands ? 0.0 : c.late_s) << c.what;
  }
  // Data without information contradict no mounting.
  CameraPoseReport vague;
  vague.rig_from_camera = given.rig_from_camera;
  vague.rotation_sigma_rad.y() = 0.21 * kDegree;
  expect_error(ErrorKind::kNumeric, "found 0.000 m and 0.21 deg, allowed 0.030 m and 0.20 deg", [&] {
    settle(given, vague);
  });
}

TEST(CameraPose, APictureOfAnotherSizeIsRefused) {
  const test::StreetDrive drive(2, 8.0, 0.6);
  const test::Scratch scratch;
  const Log log = written(drive, scratch);
  write_image(log.folder / log.images[1].file, Image(160, 90, 3));
  try {
    (void)pose_in(log);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find("160 x 90"), std::string::npos) << error.what();
  }
}

TEST(DepthEdges, LieOnTheRimsOfAPole) {
  // A sweep of one beam from -10 to 10 degrees; a pole 4 m away in front of a wall at 10 m.
  Lidar model;
  model.name = "fan";
  model.rows = {LidarRow{}};
  model.columns = 81;
  model.azimuth_first = -10.0 * kDegree;
  model.azimuth_span = 20.25 * kDegree;
  model.range_max = 50.0;
  const LogLidar lidar{model, Pose{}};
  Sweep sweep;
  sweep.rays = nominal_rays(model);
  for (int c = 0; c < 81; ++c) {
    const bool on_pole = c >= 38 && c <= 44;
    sweep.range.push_back(on_pole ? 4.0F : 10.0F);
    sweep.intensity.push_back(0.5F);
  }
  const std::vector<DepthEdge> edges = depth_edges(sweep, lidar, 0.0, 0.1);
  ASSERT_EQ(edges.size(), 2U);
  for (const DepthEdge& edge : edges) {
    const double azimuth = std::atan2(edge.p_rig.y(), edge.p_rig.x()) / kDegree;
    EXPECT_NEAR(edge.p_rig.norm(), 4.0, 1e-6);
    EXPECT_NEAR(std::abs(azimuth - 0.25), 0.875, 1e-6);  // half a step outside columns 38 and 44
    EXPECT_GT(edge.across.y() * (azimuth - 0.25), 0.0);  // outwards
    EXPECT_NEAR(edge.half_width, 4.0 * 0.125 * kDegree, 1e-6);
  }
}

TEST(EdgeImage, FindsAStepToAnEighthOfAPixel) {
  // A step at x = 20.3, blurred by the pixel area.
  Image image(64, 32, 1);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) image.at(x, y, 0) = static_cast<float>(std::clamp(x + 1 - 20.3, 0.0, 1.0));
  }
  const EdgeImage edges(Luminance(image), 1.0);
  EdgeImage::Edge edge;
  ASSERT_TRUE(edges.find({23.0, 15.5}, Eigen::Vector2d::UnitX(), 6.0, 0.02, edge));
  EXPECT_NEAR(edge.pixel.x(), 20.3, 0.12);
  EXPECT_NEAR(edge.normal.x(), 1.0, 1e-6);
  EXPECT_FALSE(edges.find({40.0, 15.5}, Eigen::Vector2d::UnitX(), 6.0, 0.02, edge));
  EXPECT_FALSE(edges.find({20.3, 15.5}, Eigen::Vector2d::UnitY(), 6.0, 0.02, edge));
}

TEST(EdgeImage, FindsNoneWhereAMaskBegins) {
  Image image(64, 32, 1);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) image.at(x, y, 0) = x < 12 ? 0.0F : x < 40 ? 0.8F : kHiddenValue;
  }
  const EdgeImage edges(Luminance(image), 1.0);
  EdgeImage::Edge edge;
  EXPECT_FALSE(edges.find({36.0, 15.5}, Eigen::Vector2d::UnitX(), 8.0, 0.01, edge));
  EXPECT_TRUE(edges.find({14.0, 15.5}, Eigen::Vector2d::UnitX(), 8.0, 0.01, edge));
  EXPECT_TRUE(edges.is_open({36.9, 15.5}));  // masked pixels affect three neighbours
  EXPECT_FALSE(edges.is_open({37.1, 15.5}));
}

}  // namespace
}  // namespace simuli::calibration
