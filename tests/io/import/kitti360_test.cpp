#include "io/import/kitti360/kitti360.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "io/import/kitti360/kitti360_parts.hpp"
#include "io/picture/image.hpp"
#include "tests/io/import/kitti_folder.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::KittiFolder;
using test::Scratch;

constexpr int kFrames = 5;
constexpr const char* kName = "2013_05_28_drive_0000_sync";
constexpr const char* kFisheye =
    "%YAML:1.0\n---\nmodel_type: MEI\ncamera_name: image_02\nimage_width: 10\nimage_height: 10\n"
    "mirror_parameters:\n   xi: 2.2\ndistortion_parameters:\n   k1: 0.016\n   k2: 1.6\n   p1: 4.0e-04\n"
    "   p2: 5.0e-04\nprojection_parameters:\n   gamma1: 13.4\n   gamma2:13.3\n   u0: 4.6\n   v0: 4.5\n";

/// A sequence of the room of KittiFolder, driven 1 m per frame along the data set's world x: frame 2 has no
/// pose, frame 3 no sweep, the fisheye one picture, image_03 no folder. The IMU has x forward, y right, z
/// down.
class Folder {
 public:
  explicit Folder(const Scratch& scratch) : root(scratch / "kitti360") {
    write("calibration/perspective.txt",
          "calib_time: 09-Feb-2013\nS_rect_00: 12 8\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
          "P_rect_00: 10 0 6 0 0 11 4 0 0 0 1 0\nS_rect_01: 12 8\nR_rect_01: 0.8 0 0.6 0 1 0 -0.6 0 0.8\n"
          "P_rect_01: 10 0 6 -6 0 10 4 0 0 0 1 0\n");
    write("calibration/calib_cam_to_velo.txt", "0 0 1 0.8 -1 0 0 0.3 0 -1 0 -0.2\n");
    write("calibration/calib_cam_to_pose.txt",
          "image_00: 0 0 1 1.5 1 0 0 -0.3 0 1 0 -1\nimage_01: 0 0 1 1.5 1 0 0 0.3 0 1 0 -1\n"
          "image_02: 1 0 0 0.7 0 0 -1 -0.5 0 1 0 -1\nimage_03: 1 0 0 0.7 0 0 1 0.5 0 -1 0 -1\n");
    write("calibration/image_02.yaml", kFisheye);
    const std::string pictures = std::string("data_2d_raw/") + kName;
    const std::string points = std::string("data_3d_raw/") + kName + "/velodyne_points";
    for (const char* camera : {"image_00", "image_01", "image_02"}) {
      write(fmt::format("{}/{}/timestamps.txt", pictures, camera), times(0.01));
    }
    write(points + "/timestamps.txt", times(0.0));
    std::string poses;
    for (int i = 0; i < kFrames; ++i) {
      if (i != 2) poses += fmt::format("{} 1 0 0 {} 0 -1 0 500 0 0 -1 100\n", i, 1000 + i);
      for (const char* camera : {"image_00", "image_01"}) {
        picture(fmt::format("{}/{}/data_rect/{:010}.png", pictures, camera, i), 12, 8);
      }
      if (i != 3) write(points + fmt::format("/data/{:010}.bin", i), KittiFolder::sweep_bytes());
    }
    picture(pictures + "/image_02/data_rgb/0000000001.png", 10, 10);
    write(std::string("data_poses/") + kName + "/poses.txt", poses);
  }
  void write(const std::string& file, const std::string& bytes) const {
    fs::create_directories((root / file).parent_path());
    std::ofstream(root / file, std::ios::binary) << bytes;
  }
  [[nodiscard]] static std::string times(double offset_s) {
    std::string text;
    for (int i = 0; i < kFrames; ++i) {
      text += fmt::format("2013-05-28 08:46:02.{:09}\n", static_cast<int>(1e9 * (0.1 + offset_s + 0.1 * i)));
    }
    return text;
  }
  fs::path root;

 private:
  void picture(const std::string& file, int width, int height) const {
    fs::create_directories((root / file).parent_path());
    write_image(root / file, Image(width, height, 3));
  }
};

TEST(Kitti360, ASequenceBecomesALog) {
  const Scratch scratch;
  const Folder data(scratch);
  Kitti360Report report;
  const Log log = import_kitti360({data.root, "", scratch / "a.log"}, {}, report);
  Kitti360Report surveyed;
  expect_survey(import_kitti360({data.root, "", ""}, {}, surveyed), log);
  EXPECT_EQ(surveyed.absent, report.absent);
  EXPECT_EQ(log.name, kName);
  EXPECT_EQ(report.absent, 1U + 4U);  // a sweep, four pictures of the fisheye
  EXPECT_EQ(report.unposed, 0U);
  ASSERT_EQ(log.images.size(), 11U);
  ASSERT_EQ(log.sweeps.size(), 4U);
  EXPECT_NEAR(log.sweeps[0].time_start_s, -0.05, 1e-9);
  EXPECT_NEAR(log.sweeps[3].time_end_s, 0.45, 1e-9);
  EXPECT_NEAR(log.images[0].time_start_s, 0.01, 1e-9);
  // The velodyne's frame at the first pose; the pose of the second frame is interpolated.
  EXPECT_LT((log.world_from_rig.at(0.2).translation - Eigen::Vector3d(2, 0, 0)).norm(), 1e-9);
  EXPECT_LT(log.world_from_rig.at(0.4).rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-9);

  const LogCamera& left = log.camera("image_00");
  EXPECT_EQ(left.model.fy, 11.0);
  EXPECT_EQ(left.model.cx, 6.5);
  EXPECT_LT((left.rig_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(),
            1e-9);
  EXPECT_LT((left.rig_from_camera.translation - Eigen::Vector3d(0.8, 0.3, -0.2)).norm(), 1e-9);
  // Rectified: rotated by the inverse of R_rect_01 about its y axis, and 0.6 m to the right.
  const LogCamera& right = log.camera("image_01");
  EXPECT_LT((right.rig_from_camera.translation - Eigen::Vector3d(0.8, -0.3, -0.2)).norm(), 1e-9);
  EXPECT_LT((right.rig_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d(0.8, 0.6, 0)).norm(),
            1e-6);
  const LogCamera& fisheye = log.camera("image_02");
  EXPECT_EQ(fisheye.model.lens.kind(), LensKind::kMei);
  EXPECT_EQ(fisheye.model.lens.parameters().at(4), 2.2);
  EXPECT_EQ(fisheye.model.fy, 13.3);
  // It points to the left: the data set's y axis points right.
  EXPECT_LT((fisheye.rig_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(),
            1e-9);

  const fs::path sweep = fmt::format("data_3d_raw/{}/velodyne_points/data/0000000003.bin", kName);
  fs::create_directory(data.root / sweep);
  expect_input_error(
      [&] {
        (void)import_kitti360({data.root, "", scratch / "b.log"}, {}, report);
      },
      {"0000000003.bin: file: found a folder"});
}

TEST(Kitti360, SweepsAreThoseOfTheKittiImporter) {
  const Scratch scratch;
  const Folder data(scratch);
  const KittiFolder drive(scratch);
  Kitti360Report report;
  Kitti360Options options{data.root, kName, scratch / "a.log"};
  options.first = 1;
  options.last = 2;
  const Log ours = import_kitti360(options, {}, report);
  const Log theirs = import_kitti({drive.drive(), "", scratch / "b.log"});
  EXPECT_EQ(ours.sweeps.size(), 2U);
  EXPECT_EQ(report.points.points, 2U * KittiFolder::sweep_bytes().size() / 16U);
  EXPECT_EQ(report.points.unplaced, 0U);
  const LidarModel &a = ours.lidars.at(0).model, &b = theirs.lidars.at(0).model;
  EXPECT_EQ(ours.lidars[0].with_rows().columns, theirs.lidars[0].with_rows().columns);
  const Sweep ours_1 = read_sweep(ours.folder / ours.sweeps[1].file, a);
  const Sweep theirs_1 = read_sweep(theirs.folder / theirs.sweeps[1].file, b);
  EXPECT_EQ(ours_1.range, theirs_1.range);
  EXPECT_EQ(ours_1.intensity, theirs_1.intensity);
  EXPECT_EQ(ours_1.rays.azimuth, theirs_1.rays.azimuth);
}

TEST(Kitti360, FramesWithoutAPathAreLeftOut) {
  const Scratch scratch;
  const Folder data(scratch);
  data.write(std::string("data_poses/") + kName + "/poses.txt",
             "0 1 0 0 0 0 -1 0 0 0 0 -1 0\n1 1 0 0 1 0 -1 0 0 0 0 -1 0\n");
  Kitti360Report report;
  const Log log = import_kitti360({data.root, "", scratch / "a.log"}, {}, report);
  EXPECT_EQ(log.sweeps.size(), 3U);  // frame 2 is 0.1 s past the last pose
  EXPECT_EQ(report.unposed, 1U + 2U * 2U);
}

TEST(Kitti360, SaysWhatDoesNotFit) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& file,
                          const std::string& bytes,
                          const std::vector<std::string>& words,
                          std::size_t first = 0) {
    fs::remove_all(scratch / "kitti360");
    const Folder data(scratch);
    data.write(file, bytes);
    Kitti360Report report;
    Kitti360Options options{data.root, "", scratch / "x.log"};
    options.first = first;
    expect_input_error([&] { (void)import_kitti360(options, {}, report); }, words);
    EXPECT_FALSE(fs::exists(scratch / "x.log"));
  };
  const std::string poses = std::string("data_poses/") + kName + "/poses.txt";
  const std::string times = std::string("data_3d_raw/") + kName + "/velodyne_points/timestamps.txt";
  refuse(poses, "1 1 0 0 0 0 1 0 0 0 0 1 0\n1 1 0 0 0 0 1 0 0 0 0 1 0\n", {"poses.txt", "line 2", "rise"});
  refuse(poses, "1 2 0 0 0 0 1 0 0 0 0 1 0\n", {"poses.txt", "line 1", "rotation"});
  refuse(poses, "1 1 0 0 0\n", {"poses.txt", "line 1", "13 numbers"});
  refuse(poses, "90 1 0 0 0 0 1 0 0 0 0 1 0\n", {"poses.txt", "none"});
  refuse(times, "2013-05-28 08:46:02.1\n\n2013-05-28 08:46:02.3\n", {"timestamps.txt", "blank"});
  refuse("x", "", {"velodyne_points", "9 to 4 of 5"}, 9);
  refuse("data_poses/other/poses.txt", "", {"data_poses", "other", "--sequence"});
  refuse("calibration/image_02.yaml", "model_type: PINHOLE\n", {"image_02.yaml", "MEI"});
  refuse("calibration/image_02.yaml", "model_type: MEI\nk1: 1\nk1: 2\n", {"image_02.yaml", "line 3", "k1"});
  refuse("calibration/perspective.txt", "S_rect_00: 12 8\n", {"perspective.txt", "P_rect_00"});
}

}  // namespace
}  // namespace simuli
