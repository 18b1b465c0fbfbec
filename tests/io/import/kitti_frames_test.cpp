// Which frames and cameras of a KITTI drive are imported, and what is lost in it.
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti.hpp"
#include "tests/io/import/kitti_folder.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::KittiFolder;
using test::Scratch;

/// As drive 0009 does: no file, and blank lines in the files of times.
TEST(KittiImport, LostSweepsAndPicturesAreGaps) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  fs::remove(folder / KittiFolder::sweep_name(1));
  fs::remove(folder / KittiFolder::image_name(2));
  const std::string velodyne = KittiFolder::name() + "/velodyne_points/";
  for (const char* name : {"timestamps_start.txt", "timestamps.txt", "timestamps_end.txt"}) {
    std::string lines = read_file(folder / (velodyne + name));
    const std::size_t second = lines.find('\n') + 1;
    lines.erase(second, lines.find('\n', second) - second);
    folder.write(velodyne + name, lines);
  }
  KittiReport report;
  const Log log = import_kitti({folder.drive(), "", scratch / "drive.log"}, {}, &report);
  ASSERT_EQ(report.gaps.size(), 2U);
  EXPECT_EQ(report.gaps[0].sensor, "image_02");
  EXPECT_EQ(report.gaps[0].frames, std::vector<std::size_t>{2});
  EXPECT_EQ(report.gaps[1].sensor, "velodyne");
  EXPECT_EQ(report.gaps[1].frames, std::vector<std::size_t>{1});
  ASSERT_EQ(log.images.size(), 2U);
  ASSERT_EQ(log.sweeps.size(), 2U);
  constexpr double kTime_s = 2e-9;
  EXPECT_NEAR(log.sweeps[1].time_start_s, 0.2, kTime_s);
  EXPECT_NEAR(log.sweeps[1].time_end_s, 0.3, kTime_s);
  EXPECT_EQ(read_file(log.folder / log.images[1].file), read_file(folder / KittiFolder::image_name(1)));
  EXPECT_EQ(log.world_from_rig.poses().size(), 3U);

  // A file without a byte is no sweep of nothing but misses; one without a time is refused.
  folder.write(KittiFolder::sweep_name(1), "");
  KittiReport again;
  const Log same = import_kitti({folder.drive(), "", scratch / "again.log"}, {}, &again);
  EXPECT_EQ(same.sweeps.size(), 2U);
  EXPECT_EQ(again.points, report.points);
  folder.write(KittiFolder::sweep_name(1), KittiFolder::sweep_bytes());
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), "", scratch / "x.log"});
      },
      {"timestamps_start.txt: line 2: found nothing, allowed the time of 0000000001.bin"});
  for (int i = 0; i < KittiFolder::kFrames; ++i) folder.write(KittiFolder::sweep_name(i), "");
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), "", scratch / "x.log"});
      },
      {"velodyne_points/data: frames: found none of 0 to 2", "with something in it"});
}

TEST(KittiImport, TakesAPartOfADrive) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const Log whole = import_kitti({folder.drive(), "", scratch / "whole.log"});
  const Log part =
      import_kitti({.drive = folder.drive(), .output = scratch / "part.log", .first = 1, .last = 1});
  ASSERT_EQ(part.images.size(), 1U);
  ASSERT_EQ(part.sweeps.size(), 1U);
  EXPECT_EQ(read_file(part.folder / part.images[0].file), read_file(folder / KittiFolder::image_name(1)));
  EXPECT_EQ(part.start_ns, whole.start_ns + 100'000'000);
  constexpr double kTime_s = 2e-9;
  EXPECT_NEAR(part.images[0].time_start_s, 0.06, kTime_s);
  EXPECT_NEAR(part.sweeps[0].time_end_s, 0.1, kTime_s);
  // The path goes on beside the part, and says the same of it.
  const Pose there = whole.world_from_rig.at(0.16), here = part.world_from_rig.at(0.06);
  EXPECT_EQ(part.world_from_rig.poses().size(), 3U);
  EXPECT_LT((there.translation - here.translation).norm(), 1e-6);

  const auto refuse_part = [&](std::size_t first, std::size_t last, const char* found) {
    expect_input_error(
        [&] {
          (void)import_kitti(
              {.drive = folder.drive(), .output = scratch / "x.log", .first = first, .last = last});
        },
        {found, "from 0 to 2"});
  };
  refuse_part(0, 3, "frames: found 0 to 3");
  refuse_part(2, 1, "frames: found 2 to 1");
}

TEST(KittiImport, TakesTheColourCamerasThatAreNamed) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  folder.write("calib_cam_to_cam.txt",
               read_file(folder / "calib_cam_to_cam.txt") +
                   "S_rect_03: 12 8\nP_rect_03: 10 0 6 -5 0 10 4 0 0 0 1 0\n");
  const std::string left = KittiFolder::name() + "/image_02", right = KittiFolder::name() + "/image_03";
  fs::copy(folder / left, folder / right, fs::copy_options::recursive);
  const Log log = import_kitti(
      {.drive = folder.drive(), .output = scratch / "drive.log", .cameras = {"image_02", "image_03"}});
  ASSERT_EQ(log.cameras.size(), 2U);
  ASSERT_EQ(log.images.size(), 6U);
  EXPECT_EQ(log.images[1].camera, "image_03");
  // 0.05 m and -0.5 m off camera 0 along x of the cameras: the right one stands 0.55 m to the left's right.
  const Pose left_from_right =
      log.camera("image_02").rig_from_camera.inverse() * log.camera("image_03").rig_from_camera;
  EXPECT_LT((left_from_right.translation - Eigen::Vector3d(0.55, 0.0, 0.0)).norm(), 1e-12);

  const auto refuse_cameras = [&](const std::vector<std::string>& names, const std::string& part) {
    try {
      (void)import_kitti({.drive = folder.drive(), .output = scratch / "x.log", .cameras = names});
      FAIL() << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refuse_cameras({"image_00"},
                 "found \"image_00\", allowed image_02, image_03 (image_00 and image_01 see no");
  refuse_cameras({"left"}, "found \"left\", allowed image_02, image_03");
  refuse_cameras({"image_03", "image_03"}, "image_03 twice");
}

TEST(KittiImport, LeavesOutFramesThatLackEverythingAtTheEnd) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  fs::remove(folder / KittiFolder::image_name(2));
  fs::remove(folder / KittiFolder::sweep_name(2));
  const Log log = import_kitti({folder.drive(), "", scratch / "drive.log"});
  EXPECT_EQ(log.images.size(), 2U);
  EXPECT_EQ(log.sweeps.size(), 2U);
  EXPECT_EQ(log.world_from_rig.poses().size(), 3U);
}

}  // namespace
}  // namespace simuli
