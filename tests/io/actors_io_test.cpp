// Tests actors in log.json, in scene.json with the particles' actor numbers in the PLY files, and in label
// files of the KITTI tracking benchmark.
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>

#include "host/core/scene/particle_order.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/log/log_json.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/ply.hpp"
#include "io/synth/street.hpp"
#include "tests/io/ascii_ply.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace actors_io_test {

using Eigen::Vector3d;
using test::expect_input_error;
using test::Scratch;

constexpr double kTime_s = 1e-9;  // times are whole nanoseconds on disk
constexpr double kAngle = 1e-7;   // of two quaternions, by arc cosine

std::vector<Actor> two_cars() {
  Actor car;
  car.name = "car_1";
  car.kind = "car";
  car.size_m = {4.1, 1.8, 1.5};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
  car.track = {{0.05, {turn, {1.0, 2.5, -3.0}}}, {0.15, {turn, {2.0, 2.5, -3.0}}}};
  Actor other = car;
  other.name = "car_2";
  other.track[1].shift_m = {0.1, -0.2, 0.3};
  other.track[1].turn_rad = {0.01, 0.0, -0.02};
  return {car, other};
}

void expect_same(const std::vector<Actor>& found, const std::vector<Actor>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].name, expected[i].name);
    EXPECT_EQ(found[i].kind, expected[i].kind);
    EXPECT_EQ(found[i].size_m, expected[i].size_m);
    ASSERT_EQ(found[i].track.size(), expected[i].track.size());
    for (std::size_t k = 0; k < found[i].track.size(); ++k) {
      const KeyPose& a = found[i].track[k];
      const KeyPose& b = expected[i].track[k];
      EXPECT_NEAR(a.time_s, b.time_s, kTime_s);
      EXPECT_EQ(a.world_from_actor.translation, b.world_from_actor.translation);
      EXPECT_LT(a.world_from_actor.rotation.angularDistance(b.world_from_actor.rotation), kAngle);
      EXPECT_EQ(a.shift_m, b.shift_m);
      EXPECT_EQ(a.turn_rad, b.turn_rad);
    }
  }
}

Log log_with_actors(const Scratch& scratch) {
  Log log;
  log.folder = scratch.path();
  log.name = "drive";
  log.start_ns = 1317042651106324297;
  log.world_from_rig = Trajectory({{0.0, Pose{}}, {0.2, Pose{}}});
  log.actors = two_cars();
  return log;
}

TEST(ActorsInALog, AreReadAsWritten) {
  const Scratch scratch;
  write_log(log_with_actors(scratch));
  expect_same(read_log(scratch.path()).actors, two_cars());
  EXPECT_NE(read_file(scratch / "log.json").find("1317042651156324297"), std::string::npos);
}

void refuse_edit(const std::string& from, const std::string& to, const std::vector<std::string>& words) {
  const Scratch scratch;
  write_log(log_with_actors(scratch));
  std::string text = read_file(scratch / "log.json");
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  write_file_atomically(scratch / "log.json", text.replace(at, from.size(), to));
  expect_input_error([&] { (void)read_log(scratch.path()); }, words);
}

TEST(ActorsInALog, AreRefusedWhenTheyAreNone) {
  refuse_edit("\"car_2\"", "\"car_1\"", {"actors[1].name", "\"car_1\" twice"});
  refuse_edit("length_m", "length_cm", {"actors[0].length_m"});
  refuse_edit("\"height_m\": 1.5", "\"height_m\": -1.5", {"car_1: size", "-1.5", "above 0"});
  for (const char* size : {"201", "1e3", "1e6", "1e9", "1e300"}) {
    refuse_edit("\"height_m\": 1.5", std::string("\"height_m\": ") + size, {"car_1: size", "at most 200 m"});
  }
  for (const char* place : {"2e8", "-1e12", "1e300"})
    refuse_edit("-3.0", place, {"car_1: track[0]", "up to 100000000 m"});
  refuse_edit("1317042651156324297", "1317042652156324297", {"car_1: track[1]", "strictly increasing"});
  refuse_edit("shift_m", "shift", {"track[1].shift"});
  refuse_edit("\"kind\": \"car\",", "", {"actors[0].kind"});
}

SceneFile scene_with_actors() {
  SceneFile file;
  file.scene.camera_filter_px2 = kSplatVariance_px2;  // readable by the first version
  file.scene.name = "street";
  file.scene.actors = two_cars();
  file.scene.camera = GaussianSet(SetKind::kCamera, 1, 4);
  file.scene.lidar = GaussianSet(SetKind::kLidar, 0, 3);
  file.scene.camera.params.setConstant(0.5F);
  file.scene.lidar.params.setConstant(0.25F);
  file.scene.camera.actor = {0, 2, 1, 0};
  return file;
}

TEST(ActorsInAScene, AreReadAsWritten) {
  const Scratch scratch;
  SceneFile written = scene_with_actors();
  for (Eigen::Index i = 0; i < 4; ++i) written.scene.camera.opacity_logit()(i) = static_cast<float>(i);
  write_scene(scratch / "scene", written);
  const SceneFile read = read_scene(scratch / "scene");
  expect_same(read.scene.actors, written.scene.actors);
  // In the order of particles: background first, then each actor.
  const GaussianSet ordered = in_coherent_order(written.scene.camera);
  EXPECT_EQ(read.scene.camera.actor, (std::vector<std::uint32_t>{0, 0, 1, 2}));
  EXPECT_EQ(read.scene.camera.actor, ordered.actor);
  EXPECT_EQ(read.scene.camera.params, ordered.params);
  EXPECT_TRUE(read.scene.lidar.actor.empty());
  EXPECT_EQ(read_file(scratch / "scene" / "lidar.ply").find("actor"), std::string::npos);
  EXPECT_NE(read_file(scratch / "scene" / "camera.ply").find("property uint actor\n"), std::string::npos);
}

SceneFile scene_with_a_walker() {
  SceneFile file = scene_with_actors();
  Deformation& shape = file.scene.actors[1].deformation;
  shape.nodes = {2, 3, 2};
  shape.start_s = 0.05;
  shape.interval_s = 0.1;
  for (int i = 0; i < 3 * 36; ++i) shape.offsets_m.push_back(0.4 * std::sin(3.1 * i));
  return file;
}

TEST(ActorsInAScene, KeepTheirShapes) {
  const Scratch scratch;
  const SceneFile written = scene_with_a_walker();
  write_scene(scratch / "scene", written);
  const SceneFile read = read_scene(scratch / "scene");
  const Deformation& before = written.scene.actors[1].deformation;
  const Deformation& after = read.scene.actors[1].deformation;
  EXPECT_TRUE(read.scene.actors[0].deformation.empty());
  EXPECT_EQ(after.nodes, before.nodes);
  EXPECT_NEAR(after.start_s, before.start_s, kTime_s);
  EXPECT_EQ(after.interval_s, before.interval_s);
  ASSERT_EQ(after.offsets_m.size(), before.offsets_m.size());
  for (std::size_t i = 0; i < after.offsets_m.size(); ++i)
    EXPECT_NEAR(after.offsets_m[i], before.offsets_m[i], 0.5e-6);
  // Values rounded to micrometres are unchanged.
  write_scene(scratch / "again", read);
  EXPECT_EQ(read_scene(scratch / "again").scene.actors[1].deformation.offsets_m, after.offsets_m);
  // Older programs can read scenes without deformations.
  EXPECT_NE(read_file(scratch / "scene" / "scene.json").find("\"version\": 2"), std::string::npos);
  write_scene(scratch / "rigid", scene_with_actors());
  EXPECT_NE(read_file(scratch / "rigid" / "scene.json").find("\"version\": 1"), std::string::npos);
}

TEST(ActorsInAScene, AreRefusedWithShapesThatAreNone) {
  const auto refuse =
      [](const std::string& from, const std::string& to, const std::vector<std::string>& words) {
        const Scratch scratch;
        write_scene(scratch / "scene", scene_with_a_walker());
        std::string text = read_file(scratch / "scene" / "scene.json");
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        write_file_atomically(scratch / "scene" / "scene.json", text.replace(at, from.size(), to));
        expect_input_error([&] { (void)read_scene(scratch / "scene"); }, words);
      };
  const std::string field = "actors[1].deformation.knots_um";
  refuse("\"0 ", "\"0 1 ", {field, "more", "rows of 36 whole numbers"});
  refuse("\"0 ", "\"", {field, "35"});
  refuse("\"0 ", "\"0.5 ", {field, "0.5"});
  refuse("\"0 ", "\"99999999999 ", {field, "99999999999"});
  refuse("\"0 ", "\" ", {field});
  refuse("\"interval_s\": 0.1", "\"interval_s\": 0.0", {"interval_s", "above 0"});
  refuse("\"interval_s\"", "\"interval\"", {"deformation.interval"});
}

TEST(ActorsInAScene, MustBeThoseOfTheParticles) {
  const Scratch scratch;
  SceneFile file = scene_with_actors();
  file.scene.camera.actor[1] = 3;
  expect_input_error([&] { write_scene(scratch / "scene", file); },
                     {"camera.ply", "vertex 1: actor", "found 3", "0 to 2"});
  file.scene.camera.actor = {0, 1};
  expect_input_error([&] { write_scene(scratch / "scene", file); }, {"camera.ply", "actor", "2 of 4"});
  write_scene(scratch / "scene", scene_with_actors());
  GaussianSet many = scene_with_actors().scene.camera;
  many.actor[3] = 7;
  write_gaussians_ply(scratch / "scene" / "camera.ply", many);
  expect_input_error([&] { (void)read_scene(scratch / "scene"); },
                     {"camera.ply", "vertex 3: actor", "found 7"});
}

TEST(ActorsInAPly, AreWholeNumbers) {
  const Scratch scratch;
  const auto with_actor = [](const std::string& value) {
    return test::ascii_ply("property float actor\n", "1 2 3 0 0 0 0 0 0 0 1 0 0 0 " + value + "\n");
  };
  const auto good = scratch.file("good.ply", with_actor("5"));
  EXPECT_EQ(read_gaussians_ply(good, SetKind::kCamera).actor, std::vector<std::uint32_t>{5});
  for (const char* value : {"-1", "0.5", "1e10"}) {
    const auto bad = scratch.file("bad.ply", with_actor(value));
    expect_input_error([&] { (void)read_gaussians_ply(bad, SetKind::kCamera); },
                       {"vertex 0: actor", "a whole number"});
  }
}

// Rectified camera axes of an untilted mounting: x right, y down, z forward.
Pose rect00_from_velo() {
  Eigen::Matrix<double, 3, 4> m;
  m << 0, -1, 0, 0, 0, 0, -1, -0.08, 1, 0, 0, -0.27;
  return Pose::from_matrix(m);
}

kitti::SweepTimes two_sweeps() {
  const Pose end{Eigen::Quaterniond::Identity(), {2.0, 0.0, 0.0}};  // 10 m/s
  return {{0.0, 0.1}, {0.1, 0.2}, Trajectory({{0.0, Pose{}}, {0.2, end}})};
}

TEST(KittiTracking, PutsBoxesIntoTheWorldWhenTheLaserMetThem) {
  const Scratch scratch;
  // Straight ahead at 10 m, heading away (-pi/2); and to the left at 5 m, heading right.
  const auto file = scratch.file("label.txt",
                                 "0 7 Car 0 0 -1.57 1 2 3 4 1.5 1.8 4.0 0.0 1.8 9.73 -1.5707963267948966\n"
                                 "0 -1 DontCare -1 -1 -10 1 2 3 4 -1000 -1000 -1000 -10 -1 -1 -1\n"
                                 "1 7 Car 0 0 -1.57 1 2 3 4 1.5 1.8 4.1 0.0 1.8 9.73 -1.5707963267948966\n"
                                 "1 2 Van 0 0 -1.57 1 2 3 4 2.0 1.9 5.0 -5.0 1.8 -0.27 0.0\n"
                                 "9 7 Car 0 0 -1.57 1 2 3 4 1.5 1.8 4.0 0.0 1.8 9.73 -1.57\n");
  LabelReport report;
  const std::vector<Actor> actors = kitti::read_tracking(file, rect00_from_velo(), two_sweeps(), report);
  EXPECT_EQ(report.kept, 3U);
  ASSERT_EQ(actors.size(), 2U);
  EXPECT_EQ(actors[0].name, "van_2");
  EXPECT_EQ(actors[1].name, "car_7");
  EXPECT_EQ(actors[1].kind, "car");
  EXPECT_EQ(actors[1].size_m, Vector3d(4.1, 1.8, 1.5));
  ASSERT_EQ(actors[1].track.size(), 2U);
  // The direction ahead is measured at half a sweep, after 0.5 m (and 1.5 m) of motion.
  EXPECT_NEAR(actors[1].track[0].time_s, 0.05, 1e-12);
  EXPECT_NEAR(actors[1].track[1].time_s, 0.15, 1e-12);
  const Pose& ahead = actors[1].track[0].world_from_actor;
  EXPECT_TRUE(ahead.translation.isApprox(Vector3d(10.5, 0.0, -0.08 - 1.8 + 0.75), 1e-9)) << ahead.translation;
  EXPECT_TRUE((ahead.rotation * Vector3d::UnitX()).isApprox(Vector3d::UnitX(), 1e-9));
  EXPECT_TRUE((ahead.rotation * Vector3d::UnitZ()).isApprox(Vector3d::UnitZ(), 1e-9));
  // The spin starts behind and is clockwise: the left is measured after a quarter of the sweep.
  ASSERT_EQ(actors[0].track.size(), 1U);
  EXPECT_NEAR(actors[0].track[0].time_s, 0.125, 1e-12);
  const Pose& left = actors[0].track[0].world_from_actor;
  EXPECT_TRUE(left.translation.isApprox(Vector3d(1.25, 5.0, -0.08 - 1.8 + 1.0), 1e-9)) << left.translation;
  EXPECT_TRUE((left.rotation * Vector3d::UnitX()).isApprox(-Vector3d::UnitY(), 1e-9));
}

TEST(KittiTracking, NumbersFramesFromTheDrivesFirst) {
  const Scratch scratch;
  std::string lines;
  for (int frame = 0; frame < 9; ++frame) {
    lines += fmt::format("{} 7 Car 0 0 0 1 2 3 4 1.5 1.8 4.0 0.0 1.8 9.73 -1.57\n", frame);
  }
  kitti::SweepTimes sweeps = two_sweeps();
  sweeps.first = 5;
  LabelReport report;
  const std::vector<Actor> actors =
      kitti::read_tracking(scratch.file("label.txt", lines), rect00_from_velo(), sweeps, report);
  ASSERT_EQ(actors.size(), 1U);
  ASSERT_EQ(actors[0].track.size(), 2U);
  EXPECT_NEAR(actors[0].track[0].time_s, 0.05, 1e-3);
}

TEST(KittiTracking, RefusesOtherLines) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& line, const std::string& word) {
    const auto file =
        scratch.file("label.txt", "0 -1 DontCare -1 -1 -10 1 2 3 4 -1 -1 -1 -1 -1 -1 -1\n" + line);
    LabelReport report;
    expect_input_error(
        [&] {
          (void)kitti::read_tracking(file, rect00_from_velo(), two_sweeps(), report);
        },
        {"label.txt", word});
  };
  refuse("0 1 Car 0 0 0 1 2 3 4 1.5 1.8 4.0 0 1.8 9\n", "line 2: found 13 numbers, allowed 14");
  refuse("x 1 Car 0 0 0 1 2 3 4 1.5 1.8 4.0 0 1.8 9 0\n", "line 2: frame");
  refuse("0 1 Car 0 0 0 1 2 3 4 1.5 1.8 nan 0 1.8 9 0\n", "line 2: found \"nan\"");
  refuse("0 1 Car 0 0 0 1 2 3 4 1.5 0 4.0 0 1.8 9 0\n", "car_1: size");
}

TEST(StreetActor, IsWhereTheCarIs) {
  const Actor car = StreetCar{}.actor(0.0, 2.0);
  EXPECT_NO_THROW(validate(car, "street"));
  const Street street;
  for (const double time_s : {0.0, 0.73, 1.99}) {
    const Pose world_from_car = car.at(time_s);
    // Rays from all sides to the centre of the box hit the car inside the box.
    for (const Vector3d& side : {Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
      const Vector3d inside(0.0, 0.0, -0.1);
      const Vector3d origin = world_from_car * Vector3d(inside + 3.0 * side);
      const StreetHit hit = street.trace(origin, world_from_car.rotation * -side, time_s, 10.0);
      ASSERT_TRUE(hit.hit && hit.on_car);
      const Vector3d p = world_from_car.inverse() * Vector3d(origin - hit.range * side);
      EXPECT_LE((p.cwiseAbs() - 0.5 * car.size_m).maxCoeff(), 1e-9);
    }
  }
  const Street other({.car = StreetCar{.lane_m = -0.25, .speed_m_per_s = 8.0}});
  const Vector3d above = StreetCar{.lane_m = -0.25, .speed_m_per_s = 8.0}.position(1.0) + Vector3d(0, 0, 5);
  EXPECT_TRUE(other.trace(above, -Vector3d::UnitZ(), 1.0, 10.0).on_car);
  EXPECT_FALSE(Street({.car = std::nullopt}).trace(above, -Vector3d::UnitZ(), 1.0, 10.0).on_car);
}

}  // namespace actors_io_test
}  // namespace simuli
