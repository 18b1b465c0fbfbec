#include "io/import/kitti/kitti.hpp"

#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <iostream>
#include <numbers>

#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
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

/// Float32 azimuth, elevation and range at 120 m: 0.03 mm; the files' own float32 rounding: 0.01 mm.
constexpr double kReprojection_m = 1e-3;

/// Returns the largest distance between the file's points and the sweep's points, which must be in the order
/// of beams and columns.
double reprojection_error_m(const kitti::BeamPoints& beams, const Sweep& sweep, const Lidar& lidar) {
  double farthest = 0.0;
  for (std::size_t r = 0; r < beams.rows.size(); ++r) {
    std::size_t next = 0;
    for (std::size_t i = r * static_cast<std::size_t>(lidar.columns);
         i < (r + 1) * static_cast<std::size_t>(lidar.columns);
         ++i) {
      if (sweep.range[i] == 0.0F) continue;
      const Eigen::Vector3d p =
          lidar.origin(static_cast<int>(r), sweep.rays.azimuth[i]) +
          double{sweep.range[i]} * Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
      if (next < beams.rows[r].size())
        farthest = std::max(farthest, (p - beams.rows[r][next].position).norm());
      ++next;
    }
    EXPECT_EQ(next, beams.rows[r].size()) << "row " << r;
  }
  return farthest;
}

TEST(KittiImport, RefusesALinkThatLeadsRound) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const std::filesystem::path file = folder.drive() / "velodyne_points" / "data" / "0000000002.bin";
  std::filesystem::remove(file);
  std::filesystem::create_symlink(file.filename(), file);
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), "", scratch / "drive.log"});
      },
      {"0000000002.bin", "frame 2 of 0 to 2", "Too many levels"});
}

TEST(KittiImport, BuildsTheFullFiringGrid) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  KittiReport report;
  std::vector<std::size_t> done;
  const Log log = import_kitti(
      {folder.drive(), "", scratch / "drive.log"},
      [&](std::size_t i, std::size_t total) {
        EXPECT_EQ(total, 3U);
        done.push_back(i);
      },
      &report);
  EXPECT_EQ(done, (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_EQ(log.folder, scratch / "drive.log");
  KittiReport surveyed;
  expect_survey(import_kitti({folder.drive(), "", ""}, {}, &surveyed), log);
  EXPECT_EQ(surveyed.returned, report.returned);
  EXPECT_EQ(log.name, KittiFolder::name());
  const Lidar& lidar = log.lidar("velodyne").with_rows();
  EXPECT_EQ(lidar.columns, KittiFolder::kFirings);
  EXPECT_EQ(report.unplaced, 0U);
  EXPECT_EQ(report.returned, report.points);
  EXPECT_EQ(report.ring_agrees, report.points);
  EXPECT_EQ(report.rays, 3 * lidar.ray_count());
  // The number of rays in the silent sector, up to one per beam.
  const double silent =
      (KittiFolder::kSilentLast_rad - KittiFolder::kSilentFirst_rad) / (2.0 * std::numbers::pi);
  const double empty =
      1.0 - KittiFolder::kBeamStep * static_cast<double>(report.returned) / static_cast<double>(report.rays);
  EXPECT_NEAR(empty, silent, 1.0 / KittiFolder::kFirings);

  const Sweep sweep = read_sweep(log.folder / log.sweeps[1].file, lidar);
  const auto points = kitti::read_points(folder / KittiFolder::sweep_name(1));
  EXPECT_LT(reprojection_error_m(kitti::sort_into_beams(points, lidar), sweep, lidar), kReprojection_m);
  // Rays without a return are in the silent sector; one firing on either side may be lost by rounding.
  const double step = 2.0 * std::numbers::pi / KittiFolder::kFirings;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const auto row = static_cast<int>(i) / lidar.columns;
    if (sweep.range[i] != 0.0F || row % KittiFolder::kBeamStep != 0) continue;
    ASSERT_GT(sweep.rays.azimuth[i], KittiFolder::kSilentFirst_rad - step);
    ASSERT_LT(sweep.rays.azimuth[i], KittiFolder::kSilentLast_rad + step);
  }
}

TEST(KittiImport, KeepsImagesTimesAndPoses) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const Log log = import_kitti({folder.drive(), "", scratch / "drive.log"});
  ASSERT_EQ(log.images.size(), 3U);
  ASSERT_EQ(log.sweeps.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const ImageFrame& image = log.images[static_cast<std::size_t>(i)];
    EXPECT_EQ(read_file(log.folder / image.file), read_file(folder / KittiFolder::image_name(i)));
    constexpr double kTime_s = 2e-9;
    EXPECT_NEAR(image.time_start_s, 0.06 + 0.1 * i, kTime_s);
    EXPECT_EQ(image.time_start_s, image.time_end_s);
    EXPECT_NEAR(log.sweeps[static_cast<std::size_t>(i)].time_start_s, 0.1 * i, kTime_s);
    EXPECT_NEAR(log.sweeps[static_cast<std::size_t>(i)].time_end_s, 0.1 + 0.1 * i, kTime_s);
  }
  EXPECT_EQ(log.start_ns, 1317081599000000000);  // 2011-09-26 23:59:59
  // The world frame is the velodyne at the first pose; 1e-5 degree of longitude at 49 degrees north is 0.7320
  // m.
  const auto& poses = log.world_from_rig.poses();
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_NEAR(poses[0].time_s, 0.055, 2e-9);
  EXPECT_LT(poses[0].pose.translation.norm(), 1e-6);
  EXPECT_NEAR(poses[1].pose.translation.norm(), 0.7320, 1e-3);
  // For a car that heads 0.3 rad north of east, east is ahead and to the right.
  EXPECT_NEAR(std::atan2(poses[1].pose.translation.y(), poses[1].pose.translation.x()), -0.3, 1e-3);
}

TEST(KittiImport, TakesPosesFromAFile) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  const auto pose = [](int index, double time_s, double x) {
    return fmt::format(
        R"({{"index": {}, "t_sweep_forward": {:.9f}, "world_from_velo": [[1,0,0,{}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}})",
        index,
        time_s,
        x);
  };
  const auto file = [&](const std::string& frames) {
    return scratch.file("poses.json", R"({"note": "", "frames": [)" + frames + "]}");
  };
  // Half a second before midnight.
  const auto good =
      file(pose(0, 86399.05, 0.0) + ',' + pose(1, 86399.15, 1.0) + ',' + pose(2, 86399.25, 2.0));
  fs::remove_all(folder.drive() / "oxts");  // not needed in this case
  const Log log = import_kitti({folder.drive(), good, scratch / "drive.log"});
  EXPECT_NEAR(log.world_from_rig.at(0.10).translation.x(), 0.5, 1e-6);
  EXPECT_NEAR(log.world_from_rig.at(0.30).translation.x(), 2.5, 1e-6);  // the last sweep ends after its pose

  const auto other_drive = file(pose(0, 4000.0, 0.0));
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), other_drive, scratch / "x.log"});
      },
      {"poses.json", "frames[0].t_sweep_forward", "found 4000", "allowed"});
  const auto scaled = file(R"({"index": 0, "t_sweep_forward": 86399.05, "world_from_velo":)"
                           " [[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]}");
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), scaled, scratch / "x.log"});
      },
      {"poses.json", "frames[0].world_from_velo", "not rigid", "allowed"});
  EXPECT_FALSE(fs::exists(scratch / "x.log"));
}

/// Damages a valid drive and expects a one-line error with all words, and no output.
template <class Spoil>
void refuse(Spoil&& spoil, std::vector<std::string> words) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  spoil(folder);
  words.insert(words.end(), {"found", "allowed"});
  expect_input_error([&] { (void)import_kitti({folder.drive(), "", scratch / "drive.log"}); }, words);
  const auto entries = std::distance(fs::directory_iterator(scratch.path()), fs::directory_iterator());
  EXPECT_EQ(entries, 1) << "only the drive itself is left";
}

TEST(KittiImport, RefusesTruncatedFiles) {
  refuse(
      [](const KittiFolder& f) {
        const std::string png = read_file(f / KittiFolder::image_name(1));
        f.write(KittiFolder::image_name(1), png.substr(0, png.size() / 2));
      },
      {"0000000001.png"});
  refuse([](const KittiFolder& f) { f.write(KittiFolder::sweep_name(2), std::string(100, '\0')); },
         {"0000000002.bin", "size", "100 bytes", "multiple of 16"});
}

TEST(KittiImport, RefusesBadPoints) {
  const auto spoil_float = [](std::size_t place, float value) {
    return [place, value](const KittiFolder& f) {
      std::string bytes = KittiFolder::sweep_bytes();
      std::memcpy(bytes.data() + 4 * place, &value, sizeof value);
      f.write(KittiFolder::sweep_name(0), bytes);
    };
  };
  refuse(spoil_float(4 * 100 + 1, std::nanf("")), {"0000000000.bin", "point 100: y", "nan"});
  refuse(spoil_float(4 * 7, INFINITY), {"0000000000.bin", "point 7: x", "inf"});
  refuse(spoil_float(4 * 7 + 3, 1.5F), {"0000000000.bin", "point 7: reflectance", "1.5", "0 to 1"});
  refuse(
      [](const KittiFolder& f) {
        std::string bytes = KittiFolder::sweep_bytes();
        std::fill(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 64), '\0');
        f.write(KittiFolder::sweep_name(0), bytes);
      },
      {"0000000000.bin", "points outside every beam"});
}

TEST(KittiImport, RefusesMissingFilesAndKeys) {
  const std::string drive = KittiFolder::name();
  refuse([&](const KittiFolder& f) { fs::remove_all(f / (drive + "/oxts")); },
         {"oxts: folder: found no such folder", "--poses", "--no-poses"});
  refuse(
      [&](const KittiFolder& f) {
        for (const auto& record : fs::directory_iterator(f / (drive + "/oxts/data"))) fs::remove(record);
      },
      {"oxts/data: records: found none of 0 to 2"});
  refuse([](const KittiFolder& f) { fs::remove(f / "calib_velo_to_cam.txt"); },
         {"calib_velo_to_cam.txt", "the calibration of the date"});
  refuse(
      [](const KittiFolder& f) {
        f.write("calib_cam_to_cam.txt", "S_rect_02: 12 8\nR_rect_00: 1 0 0 0 1 0 0 0 1\n");
      },
      {"calib_cam_to_cam.txt: P_rect_02: found no such key, allowed 12 numbers"});
  refuse([](const KittiFolder& f) { f.write("calib_velo_to_cam.txt", "R: 2 0 0 0 2 0 0 0 2\nT: 0 0 0\n"); },
         {"calib_velo_to_cam.txt: R", "rotation"});
  refuse([&](const KittiFolder& f) { f.write(drive + "/image_02/timestamps.txt", "2011-09-26 23:59:59\n"); },
         {"image_02/timestamps.txt: lines: found 1, allowed at least 3"});
  refuse(
      [&](const KittiFolder& f) {
        fs::copy_file(f / (drive + "/velodyne_points/timestamps_end.txt"),
                      f / (drive + "/velodyne_points/timestamps.txt"),
                      fs::copy_options::overwrite_existing);
      },
      {"velodyne_points/timestamps.txt: line 1", "outside the sweep"});
  refuse([&](const KittiFolder& f) { f.write(drive + "/oxts/data/0000000000.txt", "49 8 100\n"); },
         {"0000000000.txt: record: found 3 numbers, allowed 30 numbers"});
}

TEST(KittiImport, RefusesImagesOfAnotherSize) {
  refuse([](const KittiFolder& f) { write_image(f / KittiFolder::image_name(0), Image(12, 9, 3)); },
         {"0000000000.png", "12 x 9", "12 x 8 of S_rect_02"});
}

TEST(KittiImport, NeverOverwrites) {
  const Scratch scratch;
  const KittiFolder folder(scratch);
  fs::create_directory(scratch / "drive.log");
  expect_input_error(
      [&] {
        (void)import_kitti({folder.drive(), "", scratch / "drive.log"});
      },
      {"drive.log", "found something of that name"});
  EXPECT_TRUE(fs::is_empty(scratch / "drive.log"));
}

/// The real drive 0013: 50 frames, 5.8 million points.
class KittiDrive0013 : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("SIMULI_DATA");
    if (data == nullptr) GTEST_SKIP() << "not run: KITTI's drive 0013, SIMULI_DATA is not set";
    root_ = fs::path(data) / "kitti";
    drive_ = root_ / "2011_09_26" / "2011_09_26_drive_0013_sync";
  }
  fs::path root_;
  fs::path drive_;
};

TEST_F(KittiDrive0013, EveryPointComesBackFromItsRay) {
  const Scratch scratch;
  KittiReport report;
  const Log log = import_kitti({drive_, root_ / "poses_0013.json", scratch / "drive.log"}, {}, &report);
  const Lidar& lidar = log.lidar("velodyne").with_rows();
  const double empty = 1.0 - static_cast<double>(report.returned) / static_cast<double>(report.rays);
  std::cout << fmt::format(
      "{} points, {} unplaced, {} off their ring; {} columns; {:.2f} % of the rays returned "
      "nothing; columns within {:.2f} steps of even spacing\n",
      report.points,
      report.unplaced,
      report.points - report.unplaced - report.ring_agrees,
      lidar.columns,
      100.0 * empty,
      report.azimuth_shift_max_rad / (2.0 * std::numbers::pi) * lidar.columns);
  EXPECT_EQ(log.images.size(), 50U);
  EXPECT_EQ(report.points, 5817185U);
  EXPECT_LT(static_cast<double>(report.unplaced), 0.005 * static_cast<double>(report.points));
  EXPECT_EQ(report.returned + report.unplaced, report.points);
  EXPECT_GT(static_cast<double>(report.ring_agrees), 0.9999 * static_cast<double>(report.points));
  EXPECT_GE(lidar.columns, 2150);
  EXPECT_LE(lidar.columns, 2165);
  EXPECT_GT(empty, 0.10);
  EXPECT_LT(empty, 0.20);
  for (const std::size_t i : {0U, 24U, 49U}) {
    const auto points =
        kitti::read_points(drive_ / "velodyne_points" / "data" / fmt::format("{:010}.bin", i));
    const Sweep sweep = read_sweep(log.folder / log.sweeps[i].file, lidar);
    EXPECT_LT(reprojection_error_m(kitti::sort_into_beams(points, lidar), sweep, lidar), kReprojection_m);
  }
  // The camera's pose, stored with the poses.
  const Pose camera_from_velo = log.camera("image_02").rig_from_camera.inverse();
  constexpr double kPrinted_m = 1e-7;  // the calibration has 7 digits, its rotation is orthonormalised
  EXPECT_LT((camera_from_velo.translation - Eigen::Vector3d(0.057052448, -0.075466719, -0.269386912)).norm(),
            kPrinted_m);
}

TEST_F(KittiDrive0013, OxtsAgreesWithScanRegistration) {
  const auto forward_ns = kitti::read_timestamps_ns(drive_ / "velodyne_points" / "timestamps.txt");
  const Trajectory scans =
      kitti::read_pose_file(root_ / "poses_0013.json", forward_ns, forward_ns[0], {0, 49});
  const auto calibration = kitti::read_calibration(drive_.parent_path(), true, {});
  std::vector<std::size_t> lost;
  const Trajectory oxts =
      kitti::read_oxts(drive_, {0, 49}, {0, 1000}, calibration.velo_from_imu, forward_ns[0], lost, lost);
  const auto count = static_cast<Eigen::Index>(scans.poses().size());
  ASSERT_EQ(count, 50);
  Eigen::Matrix3Xd a(3, count), b(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const TimedPose& pose = scans.poses()[static_cast<std::size_t>(i)];
    a.col(i) = pose.pose.translation;
    b.col(i) = oxts.at(pose.time_s).translation;
  }
  const Eigen::Matrix4d b_from_a = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd off =
      ((b_from_a.topLeftCorner<3, 3>() * a).colwise() + b_from_a.topRightCorner<3, 1>()) - b;
  const double rmse_m = std::sqrt(off.colwise().squaredNorm().mean());
  EXPECT_TRUE(lost.empty());
  std::cout << fmt::format("oxts and scan registration agree to {:.3f} m RMSE over {:.1f} m\n",
                           rmse_m,
                           (b.col(count - 1) - b.col(0)).norm());
  constexpr double kDrift_m = 0.15;  // 0.105 measured: both drift by centimetres over 56 m
  EXPECT_LT(rmse_m, kDrift_m);
}

}  // namespace
}  // namespace simuli
