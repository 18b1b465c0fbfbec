#include <algorithm>
#include <cmath>
#include <limits>
#include <simuli/simuli.h>
#include <string>
#include <vector>

#include "io/base/file.hpp"
#include "tests/api/small_scene.hpp"
#include "tests/io/ascii_ply.hpp"

namespace simuli {
namespace {

/// Opens what it is given; closed at the end of the test.
class CApi : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    ASSERT_EQ(simuli_device_open(nullptr, &device_), SIMULI_OK) << simuli_error();
    scene_ = open(scene_with_actor());
  }
  void TearDown() override {
    for (simuli_frame* frame : frames_) simuli_frame_close(frame);
    for (simuli_scene* scene : scenes_) simuli_scene_close(scene);
    simuli_device_close(device_);
    ScratchTest::TearDown();
  }
  simuli_scene* open(const SceneFile& file) {
    const std::string path = (folder_ / ("scene" + std::to_string(scenes_.size()))).string();
    write_scene(path, file);
    simuli_scene* scene = nullptr;
    EXPECT_EQ(simuli_scene_open(device_, path.c_str(), &scene), SIMULI_OK) << simuli_error();
    scenes_.push_back(scene);
    return scene;
  }
  simuli_shot shot(simuli_scene* scene, const char* name, double start_s = 0.0, double duration_s = 0.0) {
    simuli_shot out{};
    EXPECT_EQ(simuli_scene_shot(scene, name, start_s, start_s + duration_s, &out), SIMULI_OK)
        << simuli_error();
    return out;
  }
  simuli_frame* render(simuli_scene* scene,
                       const char* name,
                       const simuli_shot& at,
                       const std::vector<simuli_edit>& edits = {}) {
    simuli_frame* frame = nullptr;
    simuli_request request{};
    request.edits = edits.data();
    request.edit_count = edits.size();
    EXPECT_EQ(simuli_render(scene, name, &at, &request, &frame), SIMULI_OK) << simuli_error();
    frames_.push_back(frame);
    return frame;
  }
  static std::vector<float> values(const simuli_frame* frame, simuli_quantity quantity, std::size_t count) {
    std::vector<float> out(count);
    EXPECT_EQ(simuli_frame_values(frame, quantity, out.data(), count), SIMULI_OK) << simuli_error();
    return out;
  }
  static void expect_error(simuli_status found, simuli_status expected, const std::string& part) {
    EXPECT_EQ(found, expected);
    const std::string says = simuli_error();
    EXPECT_NE(says.find(part), std::string::npos) << says;
    EXPECT_EQ(says.find('\n'), std::string::npos) << says;
  }

  simuli_device* device_ = nullptr;
  simuli_scene* scene_ = nullptr;
  std::vector<simuli_scene*> scenes_;
  std::vector<simuli_frame*> frames_;
};

constexpr std::size_t kPixels = 16 * 12;

TEST_F(CApi, ListsSensorsAndRendersThem) {
  ASSERT_EQ(simuli_scene_sensor_count(scene_), 2U);
  simuli_sensor camera{}, lidar{};
  ASSERT_EQ(simuli_scene_sensor(scene_, 0, &camera), SIMULI_OK);
  ASSERT_EQ(simuli_scene_sensor(scene_, 1, &lidar), SIMULI_OK);
  EXPECT_STREQ(camera.name, "front");
  EXPECT_EQ(camera.is_camera, 1);
  EXPECT_EQ(camera.columns * camera.rows, kPixels);
  EXPECT_STREQ(lidar.name, "velodyne_vlp16");
  EXPECT_EQ(lidar.rows, 16U);
  EXPECT_EQ(lidar.duration_s, 0.1);

  const simuli_shot at = shot(scene_, "front", 0.5);
  EXPECT_NEAR(at.world_from_sensor_start.position_m[0], 0.5, 1e-9);
  const simuli_frame* picture = render(scene_, "front", at);
  const std::vector<float> rgb = values(picture, SIMULI_RGB, 3 * kPixels);
  const std::size_t middle = 6 * 16 + 8;
  EXPECT_GT(rgb[3 * middle], 0.6F);
  EXPECT_LT(rgb[3 * middle + 1], 0.4F);
  EXPECT_GT(values(picture, SIMULI_OPACITY, kPixels)[middle], 0.5F);
  EXPECT_NEAR(values(picture, SIMULI_DISTANCE, kPixels)[middle], 4.5F, 0.5F);
  EXPECT_NEAR(values(picture, SIMULI_MEDIAN, kPixels)[middle], 4.5F, 0.5F);
  EXPECT_EQ(values(picture, SIMULI_MEDIAN, kPixels)[0], 0.0F);

  const std::size_t rays = lidar.rows * lidar.columns;
  const simuli_frame* sweep = render(scene_, lidar.name, shot(scene_, lidar.name, 0.0, 0.1));
  const std::vector<float> range = values(sweep, SIMULI_RANGE, rays);
  std::vector<double> points(3 * rays);
  ASSERT_EQ(simuli_frame_points(sweep, points.data(), points.size()), SIMULI_OK) << simuli_error();
  EXPECT_GT(*std::max_element(range.begin(), range.end()), 3.0F);
  for (std::size_t i = 0; i < rays; ++i) {
    if (range[i] > 0.0F) {
      EXPECT_NEAR(points[3 * i], 6.5, 3.0) << i;
    }
  }
}

// As floats, points at northings of 5e6 m would lie on steps of half a metre.
TEST_F(CApi, PointsFarFromTheWorldsOriginKeepTheirPlace) {
  const Eigen::Vector3d utm(691000.25, 5334000.125, 500.5);
  simuli_scene* far = open(small_scene(utm));
  simuli_scene* near = open(small_scene());
  simuli_sensor lidar{};
  ASSERT_EQ(simuli_scene_sensor(far, 1, &lidar), SIMULI_OK);
  std::vector<double> there(3 * lidar.rows * lidar.columns), here(there.size());
  ASSERT_EQ(simuli_frame_points(render(far, lidar.name, shot(far, lidar.name)), there.data(), there.size()),
            SIMULI_OK);
  ASSERT_EQ(simuli_frame_points(render(near, lidar.name, shot(near, lidar.name)), here.data(), here.size()),
            SIMULI_OK);
  double worst_m = 0.0;
  for (std::size_t i = 0; i < there.size(); ++i) {
    worst_m = std::max(worst_m, std::abs(there[i] - utm[static_cast<Eigen::Index>(i % 3)] - here[i]));
  }
  EXPECT_LT(worst_m, 1e-6);
}

TEST_F(CApi, NamesOfSensorsOutliveThoseThatAreAdded) {
  simuli_sensor lidar{};
  ASSERT_EQ(simuli_scene_sensor(scene_, 0, &lidar), SIMULI_OK);
  const char* const name = lidar.name;  // so short that it may lie inside of its string
  const simuli_pose mount{{0.0, 0.0, 0.2}, {2.0, 0.0, 0.0, 0.0}};
  for (int i = 0; i < 100; ++i) {
    const std::string as = std::string("l") + std::to_string(i);
    ASSERT_EQ(simuli_scene_add_sensor(scene_, "hesai_xt32", as.c_str(), &mount), SIMULI_OK) << simuli_error();
  }
  EXPECT_STREQ(name, "front");
  ASSERT_EQ(simuli_scene_sensor(scene_, 101, &lidar), SIMULI_OK);
  EXPECT_STREQ(lidar.name, "l99");
  EXPECT_EQ(lidar.rig_from_sensor.rotation_wxyz[0], 1.0);
  expect_error(simuli_scene_add_sensor(scene_, "hesai_xt32", "l5", &mount), SIMULI_USAGE, "found \"l5\"");
  expect_error(simuli_scene_add_sensor(scene_, "hesai_xt", nullptr, &mount), SIMULI_USAGE, "hesai_xt32");
}

TEST_F(CApi, SensorsOfOnesOwn) {
  const simuli_pose ahead{{0.0, 0.0, 0.0}, {0.5, -0.5, 0.5, -0.5}};
  const double k[4] = {0.01, 0.0, 0.0, 0.0};
  simuli_camera camera{"own", "opencv_fisheye", k, 4, 16, 12, 12.0, 12.0, 8.0, 6.0, "global", 0.0};
  // The domain of a fisheye is one more parameter.
  const double parameters[5] = {0.01, 0.0, 0.0, 0.0, 1.5};
  camera.lens_parameters = parameters;
  camera.lens_parameter_count = 5;
  ASSERT_EQ(simuli_scene_add_camera(scene_, &camera, &ahead), SIMULI_OK) << simuli_error();
  const std::vector<float> rgb = values(render(scene_, "own", shot(scene_, "own")), SIMULI_RGB, 3 * kPixels);
  EXPECT_GT(rgb[3 * (6 * 16 + 8)], 0.6F);

  const simuli_lidar_row rows[2] = {{0.02, 0.0, 0.0, 0.0, 0.0, 0.0}, {-0.02, 0.0, 0.0, 0.0, 0.0, 0.0}};
  simuli_lidar lidar{"two", rows, 2, 360, 3.14, 6.283185307179586, 1, 0.1, 0.5, 100.0, 0.0};
  const simuli_pose level{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  ASSERT_EQ(simuli_scene_add_lidar(scene_, &lidar, &level), SIMULI_OK) << simuli_error();
  const std::vector<float> range = values(render(scene_, "two", shot(scene_, "two")), SIMULI_RANGE, 720);
  EXPECT_GT(std::count_if(range.begin(), range.end(), [](float r) { return r > 4.0F; }), 4);

  lidar.name = "bad";
  lidar.columns = 0;
  expect_error(simuli_scene_add_lidar(scene_, &lidar, &level), SIMULI_INPUT, "columns");
  camera.name = "bad";
  camera.fx = std::numeric_limits<double>::quiet_NaN();
  expect_error(simuli_scene_add_camera(scene_, &camera, &level), SIMULI_INPUT, "fx");
}

TEST_F(CApi, EditsActorsForGoodAndForAFrame) {
  ASSERT_EQ(simuli_scene_actor_count(scene_), 1U);
  simuli_actor car{};
  ASSERT_EQ(simuli_scene_actor(scene_, 0, &car), SIMULI_OK);
  EXPECT_STREQ(car.name, "car");
  ASSERT_EQ(car.pose_count, 2U);
  double times[2];
  simuli_pose track[2];
  ASSERT_EQ(simuli_scene_actor_track(scene_, 0, times, track, 2), SIMULI_OK);
  EXPECT_EQ(track[1].position_m[1], 2.0);

  const simuli_shot at = shot(scene_, "front");
  const auto rgb = [&](const std::vector<simuli_edit>& edits) {
    return values(render(scene_, "front", at, edits), SIMULI_RGB, 3 * kPixels);
  };
  const std::vector<float> before = rgb({});
  simuli_edit edit{SIMULI_REMOVE, "car", {}, 1.0, 0.0, nullptr, nullptr, 0, nullptr, 0.0};
  const std::vector<float> without = rgb({edit});
  EXPECT_NE(before, without);
  EXPECT_EQ(before, rgb({}));
  simuli_edit move = edit;
  move.kind = SIMULI_MOVE;
  move.by_m[1] = -4.0;
  const std::vector<float> moved = rgb({move});
  EXPECT_NE(before, moved);
  simuli_edit turn = edit;
  turn.kind = SIMULI_TURN;
  EXPECT_EQ(rgb({turn}), before);
  turn.yaw_rad = 1.5;
  EXPECT_NE(rgb({turn}), before);

  simuli_edit twice = edit;
  twice.kind = SIMULI_DUPLICATE;
  twice.new_name = "car_2";
  ASSERT_EQ(simuli_scene_edit(scene_, &twice), SIMULI_OK) << simuli_error();
  ASSERT_EQ(simuli_scene_edit(scene_, &move), SIMULI_OK) << simuli_error();
  EXPECT_EQ(simuli_scene_actor_count(scene_), 2U);
  EXPECT_NE(rgb({}), moved);  // car_2 is where car was
  twice.actor = "car_2";
  twice.kind = SIMULI_REMOVE;
  ASSERT_EQ(simuli_scene_edit(scene_, &twice), SIMULI_OK) << simuli_error();
  EXPECT_EQ(rgb({}), moved);
  ASSERT_EQ(simuli_scene_edit(scene_, &edit), SIMULI_OK) << simuli_error();
  EXPECT_EQ(rgb({}), without);
  simuli_scene* other = open(scene_with_actor());
  ASSERT_EQ(simuli_scene_add_actor(scene_, other, "car", "back"), SIMULI_OK) << simuli_error();
  EXPECT_EQ(rgb({}), before);
  expect_error(simuli_scene_edit(scene_, &edit), SIMULI_USAGE, "car");
}

TEST_F(CApi, RendersTheRaysThatAreAskedFor) {
  for (const std::size_t index : {0, 1}) {
    simuli_sensor sensor{};
    ASSERT_EQ(simuli_scene_sensor(scene_, index, &sensor), SIMULI_OK);
    const char* const name = sensor.name;
    const std::size_t rays = sensor.rows * sensor.columns;
    const auto quantity = sensor.is_camera != 0 ? SIMULI_DISTANCE : SIMULI_RANGE;
    const simuli_shot at = shot(scene_, name);
    const auto seen = [&](const simuli_request* request) {
      simuli_frame* frame = nullptr;
      EXPECT_EQ(simuli_render(scene_, name, &at, request, &frame), SIMULI_OK) << simuli_error();
      frames_.push_back(frame);
      return values(frame, quantity, rays);
    };
    const std::vector<float> all = seen(nullptr);
    std::vector<unsigned char> wanted(rays, 0);
    std::size_t kept = 0, left_out = 0;
    for (std::size_t i = 0; i < rays; ++i) {
      wanted[i] = i % 3 == 0 ? 1 : 0;
      if (all[i] > 0.0F) ++(wanted[i] != 0 ? kept : left_out);
    }
    EXPECT_GT(kept, 0U) << name;
    EXPECT_GT(left_out, 0U) << name;
    simuli_request request{};
    request.rays = wanted.data();
    request.ray_count = rays;
    const std::vector<float> some = seen(&request);
    for (std::size_t i = 0; i < rays; ++i) EXPECT_EQ(some[i], wanted[i] != 0 ? all[i] : 0.0F) << name << i;
    EXPECT_EQ(seen(nullptr), all);
    simuli_frame* frame = nullptr;
    --request.ray_count;
    expect_error(simuli_render(scene_, name, &at, &request, &frame), SIMULI_USAGE, "ray_count: found");
  }
}

TEST_F(CApi, TellsWhoIsSeenAndWhereWhatIsSeenGoes) {
  simuli_request request{};
  request.with_actors = 1;
  const auto labelled = [&](double time_s) {
    const simuli_shot at = shot(scene_, "front", time_s);
    simuli_frame* frame = nullptr;
    EXPECT_EQ(simuli_render(scene_, "front", &at, &request, &frame), SIMULI_OK) << simuli_error();
    frames_.push_back(frame);
    return frame;
  };
  const simuli_frame* now = labelled(0.0);
  const std::vector<float> who = values(now, SIMULI_ACTORS, kPixels);
  const auto car = static_cast<std::size_t>(std::count(who.begin(), who.end(), 1.0F));
  EXPECT_GT(car, 0U);
  simuli_label label{};
  std::size_t count = 0;
  ASSERT_EQ(simuli_frame_labels(scene_, now, &label, 1, &count), SIMULI_OK) << simuli_error();
  ASSERT_EQ(count, 1U);
  EXPECT_EQ(label.rays, car);
  EXPECT_EQ(label.size_m[0], 4.0);
  EXPECT_NEAR(label.world_from_actor.position_m[0], 8.0, 1e-9);
  EXPECT_NEAR(label.sensor_from_actor.position_m[2], 8.0, 1e-9);  // ahead
  EXPECT_GE(label.occlusion, 0.0);
  EXPECT_LT(label.truncation, 1.0);
  EXPECT_LE(label.projected_px[0], label.visible_px[0]);
  EXPECT_LT(label.visible_px[0], label.visible_px[2]);
  // The rig comes nearer: the car moves away from the picture's middle.
  const simuli_frame* later = labelled(0.5);
  std::vector<float> pixels(3 * kPixels), points(3 * kPixels);
  ASSERT_EQ(simuli_frame_flow(scene_, now, later, pixels.data(), points.data(), pixels.size()), SIMULI_OK)
      << simuli_error();
  const auto first = static_cast<std::size_t>(std::find(who.begin(), who.end(), 1.0F) - who.begin());
  EXPECT_EQ(pixels[3 * first + 2], 1.0F);
  EXPECT_LT(pixels[3 * first], 0.0F);
  EXPECT_NEAR(points[3 * first + 2], -0.5F, 1e-4F);
  // Of the scene as it is now.
  simuli_edit move{SIMULI_MOVE, "car", {1.0, 0.0, 0.0}, 1.0, 0.0, nullptr, nullptr, 0, nullptr, 0.0};
  ASSERT_EQ(simuli_scene_edit(scene_, &move), SIMULI_OK) << simuli_error();
  expect_error(simuli_frame_labels(scene_, now, &label, 1, &count), SIMULI_USAGE, "another scene");
  ASSERT_EQ(simuli_frame_labels(scene_, labelled(0.0), &label, 1, &count), SIMULI_OK) << simuli_error();
  EXPECT_NEAR(label.world_from_actor.position_m[0], 9.0, 1e-9);
  expect_error(simuli_frame_labels(scene_, labelled(0.0), &label, 0, &count), SIMULI_USAGE, "room: found 0");
  const simuli_frame* plain = render(scene_, "front", shot(scene_, "front"));
  expect_error(simuli_frame_labels(scene_, plain, &label, 1, &count), SIMULI_USAGE, "with_actors");
  move.kind = SIMULI_REMOVE;
  request.edits = &move;
  request.edit_count = 1;
  ASSERT_EQ(simuli_frame_labels(scene_, labelled(0.0), &label, 1, &count), SIMULI_OK) << simuli_error();
  EXPECT_EQ(count, 0U);
}

TEST_F(CApi, UngradedPicturesHaveGradients) {
  SceneFile file = small_scene();
  file.scene.color_grids = ColorGrids::identity(2, 2, 2, {{"front", 0.0}});
  for (float& value : file.scene.color_grids.values) value *= 0.5F;
  simuli_scene* scene = open(file);
  const simuli_shot at = shot(scene, "front");
  simuli_request request{};
  request.is_ungraded = 1;
  simuli_frame* plain = nullptr;
  ASSERT_EQ(simuli_render(scene, "front", &at, &request, &plain), SIMULI_OK) << simuli_error();
  frames_.push_back(plain);
  const simuli_frame* graded = render(scene, "front", at);
  const std::size_t middle = 3 * (6 * 16 + 8);
  const float red = values(plain, SIMULI_RGB, 3 * kPixels)[middle];
  EXPECT_GT(red, 0.6F);
  EXPECT_NEAR(values(graded, SIMULI_RGB, 3 * kPixels)[middle], 0.5F * red, 1e-3F);
  const std::vector<float> ones(kPixels, 1.0F);
  std::vector<float> gradients(14);
  ASSERT_EQ(simuli_frame_gradients(scene, plain, nullptr, ones.data(), nullptr, gradients.data(), 14),
            SIMULI_OK)
      << simuli_error();
  EXPECT_LT(gradients[10], 0.0F);  // a denser particle lets less light through
  expect_error(simuli_frame_gradients(scene, graded, nullptr, ones.data(), nullptr, gradients.data(), 14),
               SIMULI_USAGE,
               "colour grids");
}

TEST_F(CApi, ChoosesQualityAndSettings) {
  const simuli_shot at = shot(scene_, "front");
  const auto rgb = [&] { return values(render(scene_, "front", at), SIMULI_RGB, 3 * kPixels); };
  const std::vector<float> balanced = rgb();
  const char* const settings[] = {"render.alpha_cut=0.4"};
  simuli_options options{"draft", settings, 1};
  ASSERT_EQ(simuli_scene_set_options(scene_, &options), SIMULI_OK) << simuli_error();
  EXPECT_NE(rgb(), balanced);
  ASSERT_EQ(simuli_scene_set_options(scene_, nullptr), SIMULI_OK);
  EXPECT_EQ(rgb(), balanced);
  options.quality = "best";
  expect_error(simuli_scene_set_options(scene_, &options), SIMULI_USAGE, "quality: found \"best\"");
  const char* const wrong[] = {"render.alpha_cut=7"};
  options = {nullptr, wrong, 1};
  expect_error(simuli_scene_set_options(scene_, &options), SIMULI_USAGE, "render.alpha_cut");
}

TEST_F(CApi, ParticlesGoOutAndIn) {
  std::size_t rows = 0, columns = 0;
  ASSERT_EQ(simuli_scene_particles(scene_, 0, &rows, &columns, nullptr, 0), SIMULI_OK);
  ASSERT_EQ(rows, 2U);
  ASSERT_EQ(columns, 14U);
  std::vector<float> values_of_set(rows * columns);
  ASSERT_EQ(simuli_scene_particles(scene_, 0, nullptr, nullptr, values_of_set.data(), values_of_set.size()),
            SIMULI_OK);
  EXPECT_EQ(values_of_set[0], 5.0F);
  for (std::size_t i = 0; i < rows; ++i) values_of_set[10 * rows + i] = -20.0F;  // opacity logits
  ASSERT_EQ(simuli_scene_set_particles(scene_, 0, rows, values_of_set.data(), values_of_set.size()),
            SIMULI_OK)
      << simuli_error();
  const std::vector<float> opacity =
      values(render(scene_, "front", shot(scene_, "front")), SIMULI_OPACITY, kPixels);
  EXPECT_LT(*std::max_element(opacity.begin(), opacity.end()), 1e-3F);
  values_of_set[3] = std::numeric_limits<float>::quiet_NaN();
  expect_error(simuli_scene_set_particles(scene_, 0, rows, values_of_set.data(), values_of_set.size()),
               SIMULI_INPUT,
               "particles");
  expect_error(
      simuli_scene_set_particles(scene_, 0, 1, values_of_set.data(), columns), SIMULI_USAGE, "rows: found 1");
}

TEST_F(CApi, CountsBrokenSplats) {
  EXPECT_EQ(simuli_scene_left_out(scene_), 0U);
  EXPECT_EQ(simuli_scene_left_out(nullptr), 0U);
  const std::string path = (folder_ / "a.ply").string();
  write_file_atomically(path, test::half_broken_ply());
  ASSERT_EQ(simuli_scene_open(device_, path.c_str(), &scenes_.emplace_back()), SIMULI_OK) << simuli_error();
  EXPECT_EQ(simuli_scene_left_out(scenes_.back()), 1U);
  EXPECT_STREQ(simuli_scene_notes(scenes_.back()),
               "left out: 1 particles with NaN, Inf or a zero quaternion");
  EXPECT_STREQ(simuli_scene_notes(scene_), "");
}

TEST_F(CApi, SaysWhatIsWrong) {
  simuli_scene* none = nullptr;
  expect_error(simuli_scene_open(device_, "/nowhere", &none), SIMULI_INPUT, "/nowhere");
  EXPECT_EQ(none, nullptr);
  simuli_device* device = nullptr;
  expect_error(simuli_device_open("no such device", &device), SIMULI_DEVICE, "no such device");
  expect_error(simuli_scene_open(nullptr, "x", &none), SIMULI_USAGE, "device: found NULL");
  simuli_shot at{};
  expect_error(simuli_scene_shot(scene_, "rear", 0.0, 0.0, &at), SIMULI_USAGE, "rear");
  expect_error(simuli_scene_shot(scene_, "front", 9.0, 9.0, &at), SIMULI_INPUT, "9");
  simuli_frame* frame = nullptr;
  expect_error(simuli_render(scene_, "front", &at, nullptr, &frame), SIMULI_USAGE, "quaternion");
  at = shot(scene_, "front");
  at.time_end_s = -1.0;
  expect_error(simuli_render(scene_, "front", &at, nullptr, &frame), SIMULI_USAGE, "end before its start");
  at.time_end_s = std::numeric_limits<double>::quiet_NaN();
  expect_error(simuli_render(scene_, "front", &at, nullptr, &frame), SIMULI_USAGE, "non-finite");
  const simuli_frame* picture = render(scene_, "front", shot(scene_, "front"));
  float one = 0.0F;
  expect_error(simuli_frame_values(picture, SIMULI_RGB, &one, 1), SIMULI_USAGE, "found 1, allowed 576");
  expect_error(simuli_frame_values(picture, SIMULI_RANGE, &one, 1), SIMULI_USAGE, "LiDAR");
  std::vector<float> known(576 / 3);
  expect_error(simuli_frame_support(scene_, picture, &one, 1), SIMULI_USAGE, "found 1, allowed 192");
  expect_error(simuli_frame_support(scene_, picture, known.data(), known.size()), SIMULI_USAGE, "support");
  simuli_sensor sensor{};
  expect_error(simuli_scene_sensor(scene_, 2, &sensor), SIMULI_USAGE, "index: found 2");
  simuli_scene_close(nullptr);
  simuli_device_close(nullptr);
  simuli_frame_close(nullptr);
}

}  // namespace
}  // namespace simuli
