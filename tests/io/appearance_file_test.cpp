#include <gtest/gtest.h>
#include <limits>
#include <utility>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/scene_parts.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

/// Eleven grids: more than one row of their picture.
SceneFile scene_with_appearance() {
  SceneFile file;
  file.scene.name = "street";
  file.scene.environment = {6, 3, {}};
  for (int i = 0; i < 54; ++i) file.scene.environment.texels.push_back(0.1F * static_cast<float>(i) - 1.0F);
  std::vector<ColorGrids::Frame> frames;
  for (int i = 0; i < 11; ++i) frames.push_back({i % 2 == 0 ? "front" : "left", 0.1 * i});
  file.scene.color_grids = ColorGrids::identity(3, 4, 2, frames);
  float value = 0.0F;
  for (float& v : file.scene.color_grids.values) v = value += 1e-3F;
  return file;
}

TEST(AppearanceFile, RoundTripKeepsEveryBit) {
  const Scratch scratch;
  const SceneFile written = scene_with_appearance();
  write_scene(scratch / "scene", written);
  const Scene read = read_scene(scratch / "scene").scene;
  EXPECT_EQ(read.environment.width, 6);
  EXPECT_EQ(read.environment.height, 3);
  EXPECT_EQ(read.environment.texels, written.scene.environment.texels);
  EXPECT_EQ(read.color_grids.frames, written.scene.color_grids.frames);
  EXPECT_EQ(read.color_grids.size_y, 4);
  EXPECT_EQ(read.color_grids.values, written.scene.color_grids.values);
}

TEST(AppearanceFile, GridsKnowWhereTheyLookIfThePathDoes) {
  SceneFile file = scene_with_appearance();
  Pose front, left;
  left.rotation = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  for (const auto& [name, rig_from_camera] : {std::pair{"front", front}, std::pair{"left", left}}) {
    const Camera model{.name = name, .width = 8, .height = 6, .fx = 9.0, .fy = 9.0, .cx = 4.0, .cy = 3.0};
    file.cameras.push_back({model, rig_from_camera});
  }
  Pose end;
  end.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  file.world_from_rig = Trajectory({{0.0, {}}, {1.0, end}});
  const Scratch scratch;
  write_scene(scratch / "scene", file);
  const ColorGrids grids = read_scene(scratch / "scene").scene.color_grids;
  ASSERT_EQ(grids.cameras.size(), 2U);
  ASSERT_EQ(grids.looks.size(), 11U);
  for (int i = 0; i < 11; ++i) {
    const double angle_rad = 0.5 * 0.1 * i + (i % 2 == 0 ? 0.0 : 1.0);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
    EXPECT_LT(grids.looks[static_cast<std::size_t>(i)].angularDistance(expected), 1e-9) << i;
  }
  file.world_from_rig = Trajectory({{0.0, {}}, {0.7, end}});  // ends 0.3 s before the last frame
  write_scene(scratch / "scene", file);
  const ColorGrids blind = read_scene(scratch / "scene").scene.color_grids;
  EXPECT_EQ(blind.frames.size(), 11U);
  EXPECT_TRUE(blind.cameras.empty() && blind.looks.empty());
}

TEST(AppearanceFile, AnAbsentOneLeavesNothingBehind) {
  const Scratch scratch;
  SceneFile file = scene_with_appearance();
  write_scene(scratch / "scene", file);
  file.scene.environment = {};
  file.scene.color_grids = {};
  write_scene(scratch / "scene", file);
  EXPECT_FALSE(std::filesystem::exists(scratch / "scene" / "environment.exr"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "scene" / "color_grids.exr"));
  const Scene read = read_scene(scratch / "scene").scene;
  EXPECT_TRUE(read.environment.empty());
  EXPECT_TRUE(read.color_grids.empty());
}

TEST(AppearanceFile, RefusesWhatDoesNotFit) {
  const Scratch scratch;
  const std::filesystem::path folder = scratch / "scene";
  write_scene(folder, scene_with_appearance());
  const Image environment = read_image(folder / "environment.exr");
  write_image(folder / "environment.exr", Image(6, 4, 3));
  expect_input_error([&] { (void)read_scene(folder); }, {"6 x 4", "6 x 3"});
  Image broken = environment;
  broken.data[5] = std::numeric_limits<float>::quiet_NaN();
  write_image(folder / "environment.exr", broken);
  expect_input_error([&] { (void)read_scene(folder); }, {"environment.exr", "finite"});
  write_image(folder / "environment.exr", environment);
  std::filesystem::remove(folder / "color_grids.exr");
  expect_input_error([&] { (void)read_scene(folder); }, {"color_grids.exr"});

  write_scene(folder, scene_with_appearance());
  const std::string text = read_file(folder / "scene.json");
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    write_file_atomically(folder / "scene.json", changed.replace(at, from.size(), to));
  };
  with("\"width_px\": 6", "\"width_px\": 1");
  expect_input_error([&] { (void)read_scene(folder); }, {"environment.width_px", "1"});
  with("\"camera\": \"left\"", "\"camera\": 7");
  expect_input_error([&] { (void)read_scene(folder); }, {"color_grids.frames[1].camera"});

  SceneFile infinite = scene_with_appearance();
  infinite.scene.color_grids.values[7] = std::numeric_limits<float>::infinity();
  expect_input_error([&] { write_scene(scratch / "other", infinite); }, {"color_grids.exr", "finite"});
}

}  // namespace
}  // namespace simuli
