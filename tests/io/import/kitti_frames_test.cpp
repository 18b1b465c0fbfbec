// Tests the selection of frames and cameras of a KITTI drive, and lost frames.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <utility>

#include "host/core/base/error.hpp"
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

/// As in drive 0009: missing files, and blank lines in the files of times.
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

  // An empty file is a missing sweep; a file without a time is rejected.
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

/// Returns three times of a file; KittiFolder's times are 60 ms, 160 ms and 260 ms after the drive's start.
std::string times_at(const std::vector<int>& times_ms) {
  std::string text;
  for (const int ms : times_ms)
    text += fmt::format("2011-09-26 23:59:{:02}.{:03}000000\n", 30 + ms / 1000, ms % 1000);
  return text;
}

/// Clocks may be set during a drive. The smallest number of frames is left out; the others are unchanged.
TEST(KittiImport, LeavesOutWhatIsOutOfOrder) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const std::string drive = KittiFolder::name(), sweeps = drive + "/velodyne_points/";
  folder.write(drive + "/image_02/timestamps.txt", times_at({160, 60, 260}));
  folder.write(sweeps + "timestamps_start.txt",
               times_at({0, 9000, 200}));  // one far ahead, not all others late
  folder.write(sweeps + "timestamps.txt", times_at({50, 9050, 250}));
  folder.write(sweeps + "timestamps_end.txt", times_at({100, 9100, 300}));
  folder.write(drive + "/oxts/timestamps.txt", times_at({50, 40, 250}));
  KittiReport report;
  const Log log = import_kitti({folder.drive(), "", scratch / "drive.log"}, {}, &report);
  EXPECT_TRUE(report.gaps.empty());
  ASSERT_EQ(report.disordered.size(), 3U);
  EXPECT_EQ(report.disordered[0].sensor, "image_02");
  EXPECT_EQ(report.disordered[0].frames.size(), 1U);
  EXPECT_EQ(report.disordered[1].sensor, "velodyne");
  EXPECT_EQ(report.disordered[1].frames, std::vector<std::size_t>{1});
  EXPECT_EQ(report.disordered[2].sensor, "oxts");
  EXPECT_EQ(report.disordered[2].frames.size(), 1U);
  EXPECT_EQ(log.images.size(), 2U);
  ASSERT_EQ(log.sweeps.size(), 2U);
  EXPECT_EQ(log.world_from_rig.poses().size(), 2U);
  EXPECT_NEAR(log.lidars[0].with_rows().sweep_s, 0.1, 1e-9);

  // Records of the trajectory may be missing, too.
  fs::remove(folder / (drive + "/oxts/data/0000000002.txt"));
  folder.write(drive + "/oxts/timestamps.txt", times_at({50, 150, 250}));
  KittiReport lost;
  const Log less = import_kitti({folder.drive(), "", scratch / "less.log"}, {}, &lost);
  ASSERT_EQ(lost.gaps.size(), 1U);
  EXPECT_EQ(lost.gaps[0].sensor, "oxts");
  EXPECT_EQ(lost.gaps[0].frames, std::vector<std::size_t>{2});
  EXPECT_EQ(less.world_from_rig.poses().size(), 2U);
}

/// The recorder paused: no frame is lost, and the pause is no sweep of the LiDAR.
TEST(KittiImport, TellsJumpsOfTheClock) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const std::string drive = KittiFolder::name(), sweeps = drive + "/velodyne_points/";
  folder.write(drive + "/image_02/timestamps.txt", times_at({60, 160, 9260}));
  folder.write(sweeps + "timestamps_start.txt", times_at({0, 100, 9200}));
  folder.write(sweeps + "timestamps.txt", times_at({50, 150, 9250}));
  folder.write(sweeps + "timestamps_end.txt", times_at({100, 200, 9300}));
  folder.write(drive + "/oxts/timestamps.txt", times_at({55, 155, 9255}));
  KittiReport report;
  const Log log = import_kitti({folder.drive(), "", scratch / "drive.log"}, {}, &report);
  EXPECT_EQ(log.sweeps.size(), 3U);
  EXPECT_EQ(log.images.size(), 3U);
  EXPECT_TRUE(report.disordered.empty());
  ASSERT_EQ(report.jumps.size(), 2U);
  EXPECT_EQ(report.jumps[0].sensor, "image_02");
  EXPECT_EQ(report.jumps[1].sensor, "velodyne");
  EXPECT_EQ(report.jumps[1].frame, 2U);
  EXPECT_NEAR(report.jumps[1].step_s, 9.1, 1e-9);
  EXPECT_NEAR(log.lidars[0].with_rows().sweep_s, 0.1, 1e-9);
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
  // The trajectory extends beyond the part, with equal poses.
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

TEST(KittiImport, TakesTheCamerasThatAreNamed) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  std::string calibration = read_file(folder / "calib_cam_to_cam.txt");
  const std::string left = KittiFolder::name() + "/image_02";
  const std::vector<std::string> cameras = {"image_02", "image_03", "image_00", "image_01"};
  for (const auto& [number, baseline] : {std::pair("00", "0"), {"01", "-5.5"}, {"03", "-5"}}) {
    const std::string name = std::string("image_") + number;
    fs::copy(folder / left, folder / (KittiFolder::name() + "/" + name), fs::copy_options::recursive);
    calibration +=
        fmt::format("S_rect_{}: 12 8\nP_rect_{}: 10 0 6 {} 0 10 4 0 0 0 1 0\n", number, number, baseline);
    if (name == "image_03") continue;
    for (int i = 0; i < KittiFolder::kFrames; ++i) {  // pictures of one channel
      write_image(folder / (KittiFolder::name() + fmt::format("/{}/data/{:010}.png", name, i)),
                  Image(12, 8, 1));
    }
  }
  folder.write("calib_cam_to_cam.txt", calibration);
  const Log log =
      import_kitti({.drive = folder.drive(), .output = scratch / "drive.log", .cameras = cameras});
  ASSERT_EQ(log.cameras.size(), 4U);
  ASSERT_EQ(log.images.size(), 12U);
  for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(log.images[c].camera, cameras[c]);
  const Image grey = read_image(log.folder / log.images[2].file);
  EXPECT_EQ(grey.width, 12);
  // At 0.05 m and -0.5 m from camera 0 along the cameras' x: the right camera is 0.55 m to the right of the
  // left one.
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
  for (const char* name : {"left", "image_04", "image_002"})
    refuse_cameras({name}, fmt::format("found \"{}\", allowed image_00, image_01, image_02, image_03", name));
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
