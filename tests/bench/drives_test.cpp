// The table of drives: what is a drive, what is measured, what is kept.
#include "bench/drives/drives.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <stdlib.h>

#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/synth/street.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli::bench {
namespace {

namespace fs = std::filesystem;

/// A street of six frames with its car, which gets 2 m far.
class DrivesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "simuli_drives_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    StreetOptions street;
    street.output = folder_ / "small.log";
    street.frames = 6;
    street.image_width = 64;
    street.image_height = 36;
    street.lidar_columns = 90;
    (void)synth_street(street);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static DrivesOptions options() {
    return {{(folder_ / "small.log").string()}, {}, {"iterations=3", "init.voxel_m=0.3"}, {}, 0.0};
  }
  static std::vector<DriveRow> run(const DrivesOptions& options) {
    return run_drives("", options, [](const std::string& line) { said_ += line + '\n'; });
  }

  inline static fs::path folder_;
  inline static std::string said_;
};

TEST_F(DrivesTest, AreKnownByTheirNumberOrFolder) {
  EXPECT_EQ(drive_name("a/2011_09_26/2011_09_26_drive_0013_sync/"), "0013");
  EXPECT_EQ(drive_name("a/2011_09_26_drive_0052"), "0052");
  EXPECT_EQ(drive_name("a/b/mine.log"), "mine");
  EXPECT_EQ(drive_name("mine_drive_x"), "mine_drive_x");
}

TEST_F(DrivesTest, WhatIsNoDriveIsRefusedByName) {
  const auto refused = [&](const std::string& text, const std::string& message) {
    expect_error(ErrorKind::kUsage, message, [&] { (void)open_drive(text, folder_); });
  };
  refused(folder_.string(), "found neither log.json nor velodyne_points, allowed street, a log folder");
  refused((folder_ / "small.log,labels=x").string(), "found a log, allowed");
  refused("x,pose=y", "drive x: found pose=y, allowed poses=FILE, labels=FILE");
  refused("x,poses=", "found poses=, allowed");
  refused("x,iterations=-1", "iterations");
}

TEST_F(DrivesTest, HasSettingsOfItsOwn) {
  const std::string log = (folder_ / "small.log").string();
  EXPECT_EQ(open_drive(log + ",image_scale=0.25,held_out_every=2", folder_).settings,
            (std::vector<std::string>{"image_scale=0.25", "held_out_every=2"}));
  EXPECT_TRUE(open_drive(log, folder_).settings.empty());
}

TEST_F(DrivesTest, ALogWithBoxesIsTrainedOnWithThemAndWithout) {
  const std::vector<DriveRow> rows = run(options());
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].title(), "small, boxes of the log");
  EXPECT_EQ(rows[1].title(), "small");
  for (const DriveRow& row : rows) {
    EXPECT_EQ(row.value("images"), 1.0);  // of six every fifth
    EXPECT_EQ(row.value("iterations"), 3.0);
    EXPECT_TRUE(std::isfinite(row.value("psnr_db")));
    EXPECT_TRUE(std::isfinite(row.value("actor_psnr_db")));  // in the log's boxes, whoever knew of them
    EXPECT_EQ(row.settings, (std::vector<std::string>{"iterations=3", "init.voxel_m=0.3"}));
  }
  EXPECT_NE(rows[0].value("actor_distance_median_m"), rows[1].value("actor_distance_median_m"));
  // It is what the program's own commands say.
  Log log = read_log(folder_ / "small.log");
  TrainingOptions same;
  same.init.voxel_m = 0.3;
  same.train.iterations = 3;
  const SceneFile scene = fit(Device::best(), log, same);
  const EvalReport report = Evaluation(Device::best(), scene, log).run();
  EXPECT_EQ(rows[0].value("psnr_db"), report.psnr_db);
  EXPECT_EQ(rows[0].value("chamfer_m"), report.lidar.chamfer_m);

  const std::string table = to_markdown(rows);
  EXPECT_NE(
      table.find("| held-out frames | small, boxes of the log, 32 x 18 px | small, 32 x 18 px |\n| --- |"),
      std::string::npos)
      << table;
  EXPECT_NE(table.find("| every 5. frame: 1 + 1 |"), std::string::npos) << table;
  EXPECT_NE(table.find("`iterations=3 init.voxel_m=0.3`"), std::string::npos) << table;
  const nlohmann::json json = nlohmann::json::parse(to_json(rows));
  EXPECT_EQ(json.at(1).at("psnr_db"), rows[1].value("psnr_db"));
  EXPECT_EQ(json.at(1).at("labels"), false);
  EXPECT_NE(said_.find("small: PSNR dB / SSIM"), std::string::npos) << said_;
}

TEST_F(DrivesTest, WhatIsKeptIsNotMadeAgain) {
  DrivesOptions o = options();
  o.keep = folder_ / "kept";
  const std::vector<DriveRow> first = run(o);
  const fs::path row = o.keep / "small_3" / "row.json";
  EXPECT_TRUE(read_scene(o.keep / "small_boxes_3" / "scene").training.has_value());
  const auto written = fs::last_write_time(row);
  const std::vector<DriveRow> again = run(o);
  EXPECT_EQ(fs::last_write_time(row), written);
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[1].value("psnr_db"), first[1].value("psnr_db"));
  EXPECT_EQ(again[1].value("train_s"), first[1].value("train_s"));
  EXPECT_EQ(again[1].settings, first[1].settings);
  // Of another training it is made anew.
  o.settings.push_back("seed=2");
  EXPECT_NE(run(o)[1].value("psnr_db"), first[1].value("psnr_db"));
}

TEST_F(DrivesTest, EachLengthIsATrainingUntilTheQualityIsThere) {
  DrivesOptions o = options();
  o.settings = {"init.voxel_m=0.3", "init.actors=false"};
  o.lengths = {"3", "5"};
  const std::vector<DriveRow> rows = run(o);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].value("iterations"), 3.0);
  EXPECT_EQ(rows[1].value("iterations"), 5.0);
  EXPECT_GT(rows[0].value("processor_s"), 0.0);
  TrainingOptions same;
  same.init.voxel_m = 0.3;
  same.init.actors = false;
  same.train.iterations = 5;
  const Log log = read_log(folder_ / "small.log");
  const SceneFile scene = fit(Device::best(), log, same);
  EXPECT_EQ(rows[1].value("psnr_db"), Evaluation(Device::best(), scene, log).run().psnr_db);

  o.time_to_db = rows[0].value("psnr_db") - 0.01;
  said_.clear();
  EXPECT_EQ(run(o).size(), 2U);  // with labels and without
  EXPECT_NE(said_.find("dB with 3 iterations, "), std::string::npos) << said_;
  o.lengths = {"5", "3"};
  expect_error(ErrorKind::kUsage, "--lengths: found 3, allowed more than before it", [&] { (void)run(o); });
}

}  // namespace
}  // namespace simuli::bench
