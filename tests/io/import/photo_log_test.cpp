// Tests importers of posed photographs: both formats of COLMAP, and transforms.json.
#include "io/import/photos/photo_log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "io/picture/image.hpp"
#include "io/splat/ply.hpp"
#include "tests/io/linear.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/survey.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::expect_survey;
using test::Scratch;

void write_photos(const fs::path& folder, int count) {
  fs::create_directories(folder);
  for (int i = 0; i < count; ++i) {
    Image image(8, 6, 3);
    for (float& v : image.data) v = 0.1F * static_cast<float>(i);
    write_image(folder / fmt::format("{}.png", i), image);
  }
}

template <class T>
void put(std::string& to, T value) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof(T));
  to.append(bytes.data(), bytes.size());
}

constexpr int kPhotos = 4;
/// Photograph i is at x = 2 i along +z, y down; COLMAP stores camera_from_world.
std::string colmap_images_text() {
  std::string text = "# comment\n";
  for (int i = 0; i < kPhotos; ++i)
    text += fmt::format("{} 1 0 0 0 {} 0 0 7 {}.png\n1 2 -1\n", i + 1, -2 * i, i);
  return text;
}

void write_colmap_text(const fs::path& folder, const std::string& camera) {
  fs::create_directories(folder);
  std::ofstream(folder / "cameras.txt") << "# comment\n" << camera << '\n';
  std::ofstream(folder / "images.txt") << colmap_images_text();
  std::ofstream(folder / "points3D.txt") << "1 0 1 20 9 9 9 0.5 1 0 2 0 3 0\n2 2 0 20 9 9 9 0.5 1 1 2 1 3 1\n"
                                         << "3 5 5 5 9 9 9 0.5 1 2\n";  // visible once: left out
}

void write_colmap_binary(const fs::path& folder) {
  fs::create_directories(folder);
  std::string cameras, images, points;
  put<std::uint64_t>(cameras, 1);
  put<std::int32_t>(cameras, 7);
  put<std::int32_t>(cameras, 4);  // OPENCV
  put<std::uint64_t>(cameras, 8);
  put<std::uint64_t>(cameras, 6);
  for (const double p : {9.0, 10.0, 4.0, 3.0, 0.01, 0.0, 0.001, 0.0}) put(cameras, p);
  put<std::uint64_t>(images, kPhotos);
  for (int i = 0; i < kPhotos; ++i) {
    put<std::int32_t>(images, i + 1);
    for (const double v : {1.0, 0.0, 0.0, 0.0, -2.0 * i, 0.0, 0.0}) put(images, v);
    put<std::int32_t>(images, 7);
    images += fmt::format("{}.png", i) + '\0';
    put<std::uint64_t>(images, 1);
    images += std::string(24, '\1');
  }
  put<std::uint64_t>(points, 3);
  for (int i = 0; i < 3; ++i) {
    put<std::uint64_t>(points, static_cast<std::uint64_t>(i));
    for (const double v : {2.0 * i, 1.0 - i, 20.0}) put(points, v);
    points += std::string(11, '\1');
    const std::uint64_t views = i < 2 ? 3 : 1;
    put(points, views);
    points += std::string(8 * views, '\1');
  }
  std::ofstream(folder / "cameras.bin", std::ios::binary) << cameras;
  std::ofstream(folder / "images.bin", std::ios::binary) << images;
  std::ofstream(folder / "points3D.bin", std::ios::binary) << points;
}

constexpr const char* kOpencv = "7 OPENCV 8 6 9 10 4 3 0.01 0 0.001 0";

TEST(Colmap, TextAndBinaryAreTheSameLog) {
  const Scratch scratch;
  write_photos(scratch / "images", kPhotos);
  write_colmap_text(scratch / "text", kOpencv);
  write_colmap_binary(scratch / "sparse/0");
  PhotoReport text_report, binary_report;
  const Log text = import_colmap({scratch / "text", {}, scratch / "t.log"}, {}, text_report);
  const Log binary =
      import_colmap({scratch.path(), scratch / "images", scratch / "b.log"}, {}, binary_report);
  PhotoReport surveyed;
  expect_survey(import_colmap({scratch / "text", {}, ""}, {}, surveyed), text);
  for (const PhotoReport& report : {text_report, binary_report, surveyed}) {
    EXPECT_EQ(report.photos, 4U);
    EXPECT_EQ(report.points, 2U);
    EXPECT_NEAR(report.metres_per_unit, 0.5, 0.02);  // points are 20 units away: 10 m
  }
  ASSERT_EQ(text.images.size(), 4U);
  EXPECT_TRUE(text.sweeps.empty());
  EXPECT_EQ(text.cameras.at(0).model.lens.parameters(), binary.cameras.at(0).model.lens.parameters());
  EXPECT_EQ(text.cameras[0].model.fy, 10.0);
  EXPECT_EQ(text.cameras[0].model.lens.kind(), LensKind::kOpencvPinhole);
  // Steps of 1 m; the camera points along z of the model, its down axis is the world's -z after levelling.
  const auto at = [](const Log& log, double t) {
    return log.world_from_rig.at(t) * log.cameras[0].rig_from_camera;
  };
  for (const Log& log : {text, binary}) {
    EXPECT_NEAR((at(log, 3.0).translation - at(log, 2.0).translation).norm(), 1.0, 0.05);
    EXPECT_NEAR((at(log, 1.0).rotation * Eigen::Vector3d::UnitY()).z(), -1.0, 1e-9);
    // The rig has the direction of its camera, x forward.
    EXPECT_LT((log.world_from_rig.at(1.0).rotation * Eigen::Vector3d::UnitX() -
               at(log, 1.0).rotation * Eigen::Vector3d::UnitZ())
                  .norm(),
              1e-9);
    const auto points = read_points_ply(log.folder / log.points);
    const Eigen::Vector3d seen = at(log, 0.0).inverse() * points.at(0);
    EXPECT_NEAR(seen.z(), 10.0, 0.5);
    EXPECT_NEAR(seen.y(), 0.5, 0.05);
  }
  EXPECT_EQ(read_image(text.folder / text.images[2].file).at(0, 0, 0),
            read_image(scratch / "images/2.png").at(0, 0, 0));
}

TEST(Colmap, SaysWhatIsMissing) {
  const Scratch scratch;
  PhotoReport report;
  const auto run = [&](const fs::path& model) {
    (void)import_colmap({model, {}, scratch / "x.log"}, {}, report);
  };
  expect_input_error([&] { run(scratch / "nothing"); }, {"COLMAP model"});
  write_colmap_text(scratch / "text", kOpencv);
  expect_input_error([&] { run(scratch / "text"); }, {"photographs", "--images"});
  write_photos(scratch / "images", kPhotos);
  write_colmap_text(scratch / "text", "7 FOV 8 6 9 10 4 3 0.1");
  expect_input_error([&] { run(scratch / "text"); }, {"camera 7", "FOV"});
  write_colmap_text(scratch / "text", "7 THIN_PRISM_FISHEYE 8 6 9 10 4 3 0 0 0 0 0 0 0 0");
  expect_input_error([&] { run(scratch / "text"); }, {"camera 7", "found THIN_PRISM_FISHEYE"});
  write_colmap_text(scratch / "text", "7 DIVISION 8 6 9 10 4 3 0.1");
  expect_input_error([&] { run(scratch / "text"); }, {"camera 7", "found DIVISION"});
  write_colmap_text(scratch / "text", "\xEF\xBB\xBF# as Windows writes it");
  expect_input_error([&] { run(scratch / "text"); }, {"cameras.txt: line: found \"\\xef\\xbb\\xbf# as"});
  write_colmap_text(scratch / "text", "8 PINHOLE 8 6 9 10 4 3");
  expect_input_error([&] { run(scratch / "text"); }, {"camera of 0.png", "7"});
  write_colmap_text(scratch / "text", "7 PINHOLE 9 6 9 10 4 3");
  expect_input_error([&] { run(scratch / "text"); }, {"0.png", "8 x 6", "9 x 6"});
  EXPECT_FALSE(fs::exists(scratch / "x.log"));
  fs::remove_all(scratch / "text");
  write_colmap_binary(scratch / "text");
  fs::resize_file(scratch / "text/images.bin", 100);
  expect_input_error([&] { run(scratch / "text"); }, {"images.bin", "its end"});
}

TEST(Colmap, BlankLinesOfTheTextAreNoImages) {
  const Scratch scratch;
  write_photos(scratch / "images", kPhotos);
  write_colmap_text(scratch / "text", kOpencv);
  const fs::path file = scratch / "text/images.txt";
  const auto count = [&](const std::string& text) {
    std::ofstream(file) << text;
    return read_colmap({scratch / "text", {}, {}}).photos.size();
  };
  const std::string sound = colmap_images_text(), observed = "1 2 -1\n";
  const auto with = [&](const std::string& second) {
    std::string text = sound;
    for (std::size_t at = 0; (at = text.find(observed, at)) != std::string::npos; at += second.size())
      text.replace(at, observed.size(), second);
    return text;
  };
  EXPECT_EQ(count("\n" + sound), 4U);
  EXPECT_EQ(count("\n \t\r\n" + with("1 2 -1\n\n")), 4U);
  EXPECT_EQ(count(with("\n")), 4U);         // no visible points
  EXPECT_EQ(count(with(" \r\n\n\n")), 4U);  // and blank lines between
  EXPECT_EQ(count(with("1.5 -2e0 7 3 4 -1\n")), 4U);
  // Otherwise half of the photographs would be parsed as points of the others.
  for (const char* second : {"", "1 2\n", "1 x 3\n"})
    expect_input_error([&] { (void)count(with(second)); }, {"images.txt: line", "POINT3D_ID"});
}

TEST(Colmap, PhotographsWithoutAPoseAndBlanksBehindNames) {
  const Scratch scratch;
  write_photos(scratch / "images", kPhotos);
  write_colmap_text(scratch / "text", kOpencv);
  std::string images = colmap_images_text();
  images.replace(images.find(" 0.png"), 6, " 0.png  \t");
  std::ofstream(scratch / "text/images.txt") << images << "9 0 0 0 0 1 2 3 7 1.png\n\n";
  PhotoReport report;
  EXPECT_EQ(import_colmap({scratch / "text", {}, ""}, {}, report).images.size(), 4U);
  EXPECT_EQ(report.notes, std::vector<std::string>{"1 photographs without a pose are left out"});
  fs::remove_all(scratch / "images");
  fs::create_directory(scratch / "images");
  test::expect_error(
      ErrorKind::kNothing,
      [&] {
        (void)import_colmap({scratch / "text", {}, ""}, {}, report);
      },
      {"images.txt", "none of 4, of which the first is " + (scratch / "images/0.png").string()});
}

TEST(Colmap, SmallerPhotographsAndSuchNamedTwice) {
  const Scratch scratch;
  write_photos(scratch / "images_2", kPhotos);
  write_colmap_text(scratch / "text", "7 PINHOLE 17 11 9 10 8.5 5.5");
  std::ofstream(scratch / "text/images.txt", std::ios::app) << "9 1 0 0 0 70 0 0 7 2.png\n1 2 -1\n";
  PhotoReport report;
  const Log log = import_colmap({scratch / "text", scratch / "images_2", scratch / "x.log"}, {}, report);
  ASSERT_EQ(log.images.size(), 4U);
  EXPECT_EQ(report.photos, 4U);
  EXPECT_EQ(report.notes.size(), 2U);
  const Camera& camera = log.cameras.at(0).model;
  EXPECT_EQ(camera.width, 8);
  EXPECT_DOUBLE_EQ(camera.fx, 9.0 * 8 / 17);
  EXPECT_DOUBLE_EQ(camera.cy, 3.0);
  write_colmap_text(scratch / "text", "7 PINHOLE 16 16 9 10 8 8");  // cropped, not scaled
  expect_input_error(
      [&] {
        (void)import_colmap({scratch / "text", scratch / "images_2", scratch / "y.log"}, {}, report);
      },
      {"8 x 6", "16 x 16"});
}

TEST(Colmap, PointsWithoutAnyTrackAreAllTaken) {
  const Scratch scratch;
  write_photos(scratch / "images", kPhotos);
  write_colmap_text(scratch / "text", kOpencv);
  const auto count = [&](const std::string& text) {
    std::ofstream(scratch / "text/points3D.txt") << text;
    return read_colmap({scratch / "text", {}, {}}).points.size();
  };
  EXPECT_EQ(count("1 0 1 20 9 9 9 0.5\n2 2 0 20 9 9 9 0.5\n3 5 5 5 9 9 9 0.5\n"), 3U);
  EXPECT_EQ(count("1 0 1 20 9 9 9 0.5\n2 2 0 20 9 9 9 0.5 1 1 2 1 3 1\n"), 1U);
}

TEST(PhotoLog, NumbersInNamesCountAsNumbers) {
  std::vector<std::string> names{
      "b", "a10.png", "a2.png", "a1/10.png", "a1/9.png", "a01.png", "a1.png", "a", ""};
  std::sort(names.begin(), names.end(), is_before);
  EXPECT_EQ(names,
            (std::vector<std::string>{
                "", "a", "a01.png", "a1.png", "a1/9.png", "a1/10.png", "a2.png", "a10.png", "b"}));
}

std::string transforms(const std::string& head, const std::string& model) {
  std::string frames;
  for (int i = 0; i < kPhotos; ++i) {
    // At x = 3 i, camera axes of OpenGL: it points along its -z, the world's +y; up is +z.
    frames += fmt::format(
        R"({}{{"file_path": "images/{}.png", "sharpness": 3,
             "transform_matrix": [[1, 0, 0, {}], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]}})",
        i > 0 ? "," : "",
        i,
        3 * i);
  }
  return fmt::format(R"({{{} "camera_model": "{}", "frames": [{}], "aabb_scale": 4}})", head, model, frames);
}

TEST(Nerfstudio, ListsAreReadInProportionToTheirLength) {
  const Scratch scratch;
  write_photos(scratch / "images", 1);
  fs::path files[2];
  for (const int which : {0, 1}) {
    std::string text = transforms(R"("fl_x": 9, "w": 8, "h": 6,)", "OPENCV");
    const std::size_t from = text.find('[') + 1, end = text.find("{\"file_path", from + 1);
    const std::string frame = text.substr(from, end - from);
    std::string more;
    for (int i = 0; i < 10'000 * (which + 1); ++i) {
      more += frame;
      more.replace(more.size() - frame.size() + frame.find("images/0"), 8, "absent/0");
    }
    files[which] = scratch.file(fmt::format("{}.json", which), text.insert(from, more));
  }
  PhotoReport report;
  test::expect_linear([&](int which) { (void)import_nerfstudio({files[which], ""}, {}, report); });
}

TEST(Nerfstudio, PosesAreOurs) {
  const Scratch scratch;
  write_photos(scratch / "images", kPhotos - 1);  // one of the listed files is missing
  const std::string head = R"("fl_x": 9, "w": 8.0, "h": 6.0, "cx": 4.5, "k1": 0.01,)";
  const fs::path file = scratch.file("transforms.json", transforms(head, "OPENCV"));
  PhotoReport report;
  const Log log = import_nerfstudio({file, scratch / "n.log"}, {}, report);
  PhotoReport surveyed;
  expect_survey(import_nerfstudio({file, ""}, {}, surveyed), log);
  EXPECT_EQ(report.photos, 3U);
  EXPECT_EQ(report.absent, 1U);
  EXPECT_NEAR(report.metres_per_unit, 0.5 / 3.0, 1e-9);
  EXPECT_TRUE(log.points.empty());
  const Camera& camera = log.cameras.at(0).model;
  EXPECT_EQ(camera.fy, 9.0);
  EXPECT_EQ(camera.cx, 4.5);
  EXPECT_EQ(camera.cy, 3.0);
  const Pose world_from_camera = log.world_from_rig.at(2.0) * log.cameras[0].rig_from_camera;
  EXPECT_LT((world_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_LT((world_from_camera.rotation * Eigen::Vector3d::UnitY() + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(world_from_camera.translation.x(), 0.5, 1e-9);

  fs::create_directory(scratch / "images" / fmt::format("{}.png", kPhotos - 1));
  expect_input_error(
      [&] {
        (void)import_nerfstudio({file, scratch / "x.log"}, {}, report);
      },
      {"3.png: file: found a folder"});
  // instant-ngp's scripts write is_fisheye and no camera_model.
  std::string fisheye =
      transforms(R"("fl_x": 9, "k1": 0.05, "k4": 0.01, "is_fisheye": true, "w": 8, "h": 6,)", "");
  fisheye.replace(fisheye.find(R"("camera_model": "", )"), 20, "");
  const PhotoSet set = read_nerfstudio({scratch.file("fisheye.json", fisheye), {}});
  EXPECT_EQ(set.cameras.at(0).lens.kind(), LensKind::kOpencvFisheye);
  const PhotoSet tall = read_nerfstudio(
      {scratch.file("tall.json",
                    transforms(R"("fl_x": 9, "camera_angle_y": 0.6, "w": 8, "h": 6,)", "OPENCV")),
       {}});
  EXPECT_NEAR(tall.cameras.at(0).fy, 3.0 / std::tan(0.3), 1e-12);
  const auto refuse = [&](const std::string& text, const char* word) {
    expect_input_error(
        [&] {
          (void)import_nerfstudio({scratch.file("bad.json", text), scratch / "x.log"}, {}, report);
        },
        {"bad.json", word});
  };
  refuse(transforms(head, "EQUIRECTANGULAR"), "camera_model");
  refuse(transforms(head + R"("is_fisheye": true,)", "OPENCV"), "is_fisheye");
  refuse(transforms(head + R"("k4": 0.1,)", "OPENCV"), "k4");
  refuse(transforms(head + R"("latlong": true,)", "OPENCV"), "latlong");
  // Motion during a photograph is rejected, at any position in the file.
  std::string moved = transforms(head + R"("rolling_shutter": [0, 0, 1, 0],)", "OPENCV");
  moved.insert(moved.find("\"transform_matrix\""), "\"transform_matrix_end\": [], ");
  EXPECT_EQ(read_nerfstudio({scratch.file("moved.json", moved), {}}).notes,
            std::vector<std::string>{
                "rolling_shutter, transform_matrix_end left out: each photograph counts as taken in "
                "one moment, at transform_matrix"});
  const PhotoSet bent = read_nerfstudio({scratch.file("pinhole.json", transforms(head, "PINHOLE")), {}});
  EXPECT_EQ(bent.cameras.at(0).lens.kind(),
            LensKind::kOpencvPinhole);  // k1 is used independently of the name
  refuse(transforms(R"("fl_x": 9, "w": 8.5, "h": 6,)", "OPENCV"), "w: found 8.5");
  refuse(transforms(R"("w": 8, "h": 6,)", "OPENCV"), "camera_angle_x");
  refuse(transforms(R"("w": 8, "h": 6, "camera_angle_x": 3.2,)", "OPENCV"),
         "json: camera_angle_x: found 3.2");
  refuse(transforms(R"("fl_x": 0, "w": 8, "h": 6,)", "OPENCV"), "json: fl_x: found 0, allowed above 0");
  std::string scaled = transforms(head, "OPENCV");
  refuse(scaled.replace(scaled.find("[0, 1, 0, 0]"), 12, "[0, 2, 0, 0]"), "while reading ");
  refuse(R"({"fl_x": 9, "w": 8, "h": 6, "frames": [{"file_path": "a.png", "transform_matrix": [[1]]}]})",
         "transform_matrix");
  for (const char* row : {"[0, 0, 0, 2]", "[5, -2, 1, 1]"}) {
    std::string other = transforms(head, "OPENCV");
    refuse(other.replace(other.find("[0, 0, 0, 1]"), 12, row), "another last row");
  }
  refuse(R"({"fl_x": 9, "w": 8, "h": 6, "frames": []})", "photographs");
}

}  // namespace
}  // namespace simuli
