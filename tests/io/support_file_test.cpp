#include <gtest/gtest.h>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/scene_parts.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

SceneFile scene_with_support() {
  SceneFile file;
  file.scene.camera = GaussianSet(SetKind::kCamera, 0, 1);
  file.scene.lidar = GaussianSet(SetKind::kLidar, 0, 1);
  for (GaussianSet* set : {&file.scene.camera, &file.scene.lidar}) set->params.setConstant(0.5F);
  SupportRecord record;
  record.sensors = {{"front", SetKind::kCamera, {3, 2, -0.5, 3.0, 0.4, 2.5, 100.0}},
                    {"top", SetKind::kLidar, {4, 1, -2.0, 1.0, 0.1, 5.0, 143.25}}};
  record.views = {{0, 0.5, {Eigen::Quaterniond(0.6, 0.0, 0.0, 0.8), {1.0, 2.0, 3.0}}},
                  {1, 0.75, {Eigen::Quaterniond::Identity(), {-1.5, 0.0, 0.25}}}};
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  car.track = {{0.5, {Eigen::Quaterniond::Identity(), {9.0, 0.0, 0.0}}}};
  record.actors = {car};
  for (int i = 0; i < 10; ++i) {
    const auto x = static_cast<float>(i);
    record.cells.push_back(
        {1.0F + x, i == 3 ? static_cast<float>(kSupportFar_m) : 2.0F + x, -0.1F * x, 0.2F * x});
  }
  file.support = std::make_shared<const SupportRecord>(record);
  return file;
}

TEST(SupportFile, ComesBackWithItsScene) {
  const Scratch scratch;
  const SceneFile written = scene_with_support();
  write_scene(scratch / "scene", written);
  const SceneFile read = read_scene(scratch / "scene");
  ASSERT_NE(read.support, nullptr);
  const SupportRecord &a = *written.support, &b = *read.support;
  ASSERT_EQ(b.sensors.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(b.sensors[i].name, a.sensors[i].name);
    EXPECT_EQ(b.sensors[i].kind, a.sensors[i].kind);
    EXPECT_EQ(b.sensors[i].grid, a.sensors[i].grid);
    EXPECT_EQ(b.views[i].sensor, a.views[i].sensor);
    EXPECT_EQ(b.views[i].time_s, a.views[i].time_s);
    EXPECT_EQ(b.views[i].world_from_view.translation, a.views[i].world_from_view.translation);
  }
  ASSERT_EQ(b.actors.size(), 1U);
  EXPECT_EQ(b.actors[0].size_m, a.actors[0].size_m);
  ASSERT_EQ(b.cells.size(), a.cells.size());
  for (std::size_t i = 0; i < a.cells.size(); ++i) {
    EXPECT_EQ(b.cells[i].nearest_m, a.cells[i].nearest_m);
    EXPECT_EQ(b.cells[i].farthest_m, a.cells[i].farthest_m);
    EXPECT_EQ(b.cells[i].log_error, a.cells[i].log_error);
    EXPECT_EQ(b.cells[i].log_contrast, a.cells[i].log_contrast);
  }
  // Replaces the scene.
  write_scene(scratch / "scene", read);
  EXPECT_NE(read_scene(scratch / "scene").support, nullptr);
}

TEST(SupportFile, ScenesWithoutOneOpen) {
  const Scratch scratch;
  SceneFile file = scene_with_support();
  file.support = nullptr;
  write_scene(scratch / "scene", file);
  EXPECT_EQ(read_scene(scratch / "scene").support, nullptr);
  EXPECT_FALSE(std::filesystem::exists(scratch / "scene" / "support.exr"));
}

TEST(SupportFile, WhatIsNotAsSceneJsonSaysIsRefused) {
  const Scratch scratch;
  write_scene(scratch / "scene", scene_with_support());
  const std::filesystem::path cells = scratch / "scene" / "support.exr",
                              json = scratch / "scene" / "scene.json";
  const std::string good = read_file(cells), text = read_file(json);
  write_image(cells, Image(kSupportRow, 2, 1));
  expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"support.exr", "4096 x 2", "4096 x 1"});
  Image negative(kSupportRow, 1, 1);
  negative.data[0] = -1.0F;
  write_image(cells, negative);
  expect_input_error([&] { (void)read_scene(scratch / "scene"); }, {"support.exr", "cells", "finite"});
  std::filesystem::remove(cells);
  EXPECT_THROW((void)read_scene(scratch / "scene"), Error);
  write_file_atomically(cells, good);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_file_atomically(json, changed.replace(at, from.size(), to));
    EXPECT_THROW((void)read_scene(scratch / "scene"), Error) << to;
  };
  with("\"set\": \"camera\"", "\"set\": \"radar\"");
  with("\"columns\": 3", "\"columns\": 0");
  with("\"rays_per_rad\"", "\"rays_per_deg\"");
  SceneFile odd = scene_with_support();
  SupportRecord record = *odd.support;
  record.cells.pop_back();
  odd.support = std::make_shared<const SupportRecord>(record);
  EXPECT_THROW(write_scene(scratch / "odd", odd), Error);
  EXPECT_FALSE(std::filesystem::exists(scratch / "odd"));
}

}  // namespace
}  // namespace simuli
