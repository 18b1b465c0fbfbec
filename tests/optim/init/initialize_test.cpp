#include "optim/init/initialize.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <stdlib.h>

#include "host/core/base/error.hpp"
#include "io/picture/image.hpp"
#include "io/synth/street.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr FrameSelection kFullSize{.image_scale = 1.0};

// Pictures have 8 bits: half a step, and the same for the bilinear sample.
constexpr float kColour = 1.0F / 255.0F;
// Sweeps are float, voxel means have micrometre resolution; ranges of up to 20 m in float32.
constexpr double kPosition_m = 1e-4;

/// A log of a wall 10 m ahead of a resting rig: the picture is red on the left, green on the right, and blue
/// above the wall, beyond the LiDAR's elevations.
class InitializeScene : public testing::Test {
 protected:
  static constexpr double kWall_m = 10.0;

  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "simuli_init_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    log_.folder = pattern;
    log_.name = "wall";
    log_.cameras.push_back({camera(), rig_from_camera()});
    log_.lidars.push_back({lidar(), Pose{}});
    const Pose far_away{Eigen::Quaterniond::Identity(), {1e6 + 0.25, -2e5, 50.0}};  // like UTM coordinates
    log_.world_from_rig = Trajectory({{0.0, far_away}, {1.0, far_away}});
    for (int i = 0; i < 2; ++i) {
      const std::string number = std::to_string(i);
      const double start_s = 0.1 * i;
      log_.images.push_back({"front", "image" + number + ".png", start_s + 0.05, start_s + 0.05});
      log_.sweeps.push_back({"top", "sweep" + number + ".exr", start_s, start_s + 0.1});
      write_image(log_.folder / log_.images.back().file, picture());
      write_sweep(log_.folder / log_.sweeps.back().file, sweep());
    }
  }
  void TearDown() override { fs::remove_all(log_.folder); }

  static Camera camera() { return {"front", 80, 60, 60.0, 60.0, 40.0, 30.0, ShutterKind::kGlobal}; }
  static Pose rig_from_camera() {
    Eigen::Matrix<double, 3, 4> m;
    m << 0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0;  // z forward to x, x right to -y, y down to -z
    return Pose::from_matrix(m);
  }
  static Lidar lidar() {
    Lidar lidar = builtin_lidar("generic64");
    lidar.name = "top";
    lidar.columns = 180;
    lidar.azimuth_first = std::numbers::pi / 4;
    lidar.azimuth_span = std::numbers::pi / 2;
    return lidar;
  }
  static Image picture() {
    Image image(80, 60, 3);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) image.at(x, y, y < 20 ? 2 : (x < 40 ? 0 : 1)) = 1.0F;
    }
    return image;
  }
  static Sweep sweep() {
    Sweep sweep{nominal_rays(lidar()), {}, {}};
    for (std::size_t i = 0; i < sweep.rays.azimuth.size(); ++i) {
      const Eigen::Vector3d d = Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
      const bool is_returned = i % 10 != 0;
      sweep.range.push_back(is_returned ? static_cast<float>(kWall_m / d.x()) : 0.0F);
      sweep.intensity.push_back(is_returned ? 0.75F : 0.0F);
    }
    return sweep;
  }

  Log log_;
};

float colour_of(const GaussianSet& set, Eigen::Index row, int channel) {
  return 0.5F + kSh0 * set.sh(0)(row, channel);
}

/// One ray in ten drops in this log, like rays into glass.
InitOptions without_dark_surfaces() {
  InitOptions options;
  options.dark_surfaces = false;
  return options;
}

TEST_F(InitializeScene, LidarParticlesLieOnTheWall) {
  const SceneInit init = initialize_scene(log_, kFullSize, without_dark_surfaces());
  const GaussianSet& set = init.scene.lidar;
  EXPECT_EQ(init.scene.origin, Eigen::Vector3d(1e6, -2e5, 50.0));  // whole metres
  EXPECT_EQ(init.report.points, 2U * 64U * 180U * 9U / 10U);
  ASSERT_EQ(set.size(), static_cast<Eigen::Index>(init.report.lidar_cells));
  ASSERT_GT(set.size(), 100);
  EXPECT_LT(set.size(), static_cast<Eigen::Index>(init.report.voxels / 2));  // the wall is flat and uniform
  std::size_t flat = 0;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    ASSERT_NEAR(set.mean()(i, 0), kWall_m + 0.25, kPosition_m);
    ASSERT_NEAR(colour_of(set, i, 0), 0.75F, 1e-5F);
    const float hit = kSh0 * set.sh(0)(i, 1);
    const float drop = kSh0 * set.sh(0)(i, 2);
    ASSERT_NEAR(1.0F / (1.0F + std::exp(drop - hit)), 0.95F, 0.01F);
    const Eigen::Quaternionf q(
        set.rotation()(i, 0), set.rotation()(i, 1), set.rotation()(i, 2), set.rotation()(i, 3));
    ASSERT_NEAR(q.norm(), 1.0F, 1e-5F);
    const bool is_flat = set.log_scale()(i, 2) < set.log_scale()(i, 0) - 0.5F;
    if (is_flat) {
      ++flat;
      ASSERT_GT(std::abs((q * Eigen::Vector3f::UnitZ()).x()), 0.999F) << i;  // the wall's normal
    }
    ASSERT_GE(set.log_scale()(i, 0), std::log(0.03F) - 1e-5F);
    ASSERT_LE(set.log_scale()(i, 0), std::log(0.5F) + 1e-5F);
  }
  EXPECT_GT(flat, init.report.lidar_particles * 9 / 10);
}

TEST_F(InitializeScene, BothSetsHaveWhatSendsNothingBack) {
  const SceneInit all = initialize_scene(log_, kFullSize, {}),
                  some = initialize_scene(log_, kFullSize, without_dark_surfaces());
  const auto dark = static_cast<Eigen::Index>(all.report.dark_points);
  ASSERT_GT(dark, 0);
  EXPECT_EQ(all.scene.lidar.size(), some.scene.lidar.size() + dark);
  EXPECT_EQ(all.report.lidar_particles, some.report.lidar_particles + all.report.dark_points);
  EXPECT_EQ(all.report.camera_particles - all.report.shell_particles + all.report.unseen_points +
                all.report.joined_points + all.report.camera_thinned,
            all.report.voxels + all.report.dark_points);
  EXPECT_EQ(some.report.dark_points, 0U);
}

TEST_F(InitializeScene, CameraParticlesTakeTheColourOfThePicture) {
  InitOptions options = without_dark_surfaces();
  const SceneInit init = initialize_scene(log_, kFullSize, options);
  const GaussianSet& set = init.scene.camera;
  const auto on_points = set.size() - static_cast<Eigen::Index>(init.report.shell_particles);
  EXPECT_EQ(static_cast<std::size_t>(set.size()), init.report.camera_particles);
  EXPECT_EQ(init.report.voxels,
            static_cast<std::size_t>(on_points) + init.report.unseen_points + init.report.joined_points +
                init.report.camera_thinned);
  EXPECT_GT(init.report.unseen_points, 0U);  // the LiDAR has a wider field of view than the camera
  int left = 0;
  int right = 0;
  for (Eigen::Index i = 0; i < on_points; ++i) {
    const Eigen::Vector3f mean = set.mean().row(i);
    const double column = 40.0 - 60.0 * mean.y() / kWall_m;
    if (std::abs(column - 40.0) < 1.0) continue;  // colours mix at the edge
    const int channel = column < 40.0 ? 0 : 1;
    (channel == 0 ? left : right)++;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(colour_of(set, i, c), c == channel ? 1.0F : 0.0F, kColour) << i;
    // At least half a pixel of the picture at 10 m: no holes. Particles outside the pictures are wider than
    // their cell.
    const double least_m = i < on_points - static_cast<Eigen::Index>(init.report.filled_particles)
                               ? 0.5 * kWall_m / 60.0
                               : 0.5 * options.voxel_m;
    ASSERT_GE(set.log_scale()(i, 0), static_cast<float>(std::log(least_m)) - 1e-4F);
  }
  EXPECT_GT(left, 100);
  EXPECT_GT(right, 100);
}

TEST_F(InitializeScene, TheShellCoversWhatTheLaserDoesNotReach) {
  const SceneInit init = initialize_scene(log_, kFullSize, {});
  const GaussianSet& set = init.scene.camera;
  const auto shell = static_cast<Eigen::Index>(init.report.shell_particles);
  ASSERT_GT(shell, 20);
  EXPECT_GE(init.report.shell_distance_m, 200.0);
  int blue = 0;
  for (Eigen::Index i = set.size() - shell; i < set.size(); ++i) {
    const Eigen::Vector3f mean = set.mean().row(i);
    ASSERT_NEAR(mean.norm(), init.report.shell_distance_m, 1e-3 * init.report.shell_distance_m);
    const Eigen::Quaternionf q(
        set.rotation()(i, 0), set.rotation()(i, 1), set.rotation()(i, 2), set.rotation()(i, 3));
    ASSERT_GT((q * Eigen::Vector3f::UnitZ()).dot(mean.normalized()), 0.9999F);  // flat along the view ray
    ASSERT_LT(set.log_scale()(i, 2), set.log_scale()(i, 0) - 2.0F);
    blue += colour_of(set, i, 2) > 0.9F ? 1 : 0;
  }
  EXPECT_GT(blue, 20);  // the band above the wall
  InitOptions no_shell;
  no_shell.max_shell = 0;
  EXPECT_EQ(initialize_scene(log_, kFullSize, no_shell).report.shell_particles, 0U);
}

TEST_F(InitializeScene, SameLogAndOptionsGiveTheSameBits) {
  InitOptions options = without_dark_surfaces();
  options.max_camera = 300;
  options.max_lidar = 50;
  options.max_shell = 10;
  const SceneInit a = initialize_scene(log_, kFullSize, options);
  const SceneInit b = initialize_scene(log_, kFullSize, options);
  EXPECT_EQ(a.scene.camera.params, b.scene.camera.params);
  EXPECT_EQ(a.scene.lidar.params, b.scene.lidar.params);
  EXPECT_EQ(a.report.lidar_particles, 50U);
  EXPECT_EQ(a.report.camera_particles, 310U);
  EXPECT_EQ(a.report.shell_particles, 10U);
  EXPECT_EQ(a.report.lidar_thinned, a.report.lidar_cells - 50U);
  const FrameSelection other{.image_scale = 1.0, .seed = 2};
  EXPECT_NE(initialize_scene(log_, other, options).scene.lidar.params, a.scene.lidar.params);
}

TEST_F(InitializeScene, HeldOutFramesAreNotRead) {
  const FrameSelection half{.image_scale = 1.0, .held_out_every = 2};  // frame 1 of 2
  fs::remove(log_.folder / log_.images[1].file);
  fs::remove(log_.folder / log_.sweeps[1].file);
  std::size_t calls = 0;
  const SceneInit init = initialize_scene(log_, half, {}, [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, calls++);
    EXPECT_EQ(total, 6U);  // the sweep, and the picture three times
  });
  EXPECT_EQ(calls, 7U);  // also before the first file
  EXPECT_EQ(init.report.sweeps, 1U);
  EXPECT_EQ(init.report.images, 1U);
  EXPECT_THROW((void)initialize_scene(log_, kFullSize, {}), Error);  // the other frames are read
}

TEST_F(InitializeScene, DegreesAndImageScaleAreTaken) {
  InitOptions options;
  options.camera_sh_degree = 3;
  options.lidar_sh_degree = 0;
  const SceneInit init = initialize_scene(log_, {.image_scale = 0.5}, options);
  EXPECT_EQ(init.scene.camera.params.cols(), param_rows(3));
  EXPECT_EQ(init.scene.lidar.params.cols(), param_rows(0));
  EXPECT_TRUE((init.scene.camera.params.rightCols(45).array() == 0.0F).all());
  // Pixels of twice the size: particles at least half as wide.
  EXPECT_GE(init.scene.camera.log_scale()(0, 0), static_cast<float>(std::log(0.5 * kWall_m / 30.0)) - 1e-4F);
}

TEST_F(InitializeScene, WorksWithOneKindOfSensor) {
  Log lasers = log_;
  lasers.images.clear();
  const SceneInit without_images = initialize_scene(lasers, kFullSize, {});
  EXPECT_EQ(without_images.scene.camera.size(), 0);
  EXPECT_GT(without_images.scene.lidar.size(), 0);
  Log cameras = log_;
  cameras.sweeps.clear();
  const SceneInit without_sweeps = initialize_scene(cameras, kFullSize, {});
  EXPECT_EQ(without_sweeps.scene.lidar.size(), 0);
  EXPECT_GT(without_sweeps.report.shell_particles, 0U);
  Log nothing = cameras;
  nothing.images.clear();
  EXPECT_THROW((void)initialize_scene(nothing, kFullSize, {}), Error);
}

TEST_F(InitializeScene, OptionsOutOfRangeAreUsageErrors) {
  struct Options {
    FrameSelection frames;
    InitOptions init;
  };
  const auto refused = [&](auto set) {
    Options options;
    set(options);
    try {
      (void)initialize_scene(log_, options.frames, options.init);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([&](Options& o) { o.init.voxel_m = nan; });
  refused([&](Options& o) { o.init.voxel_m = 0.0; });
  refused([&](Options& o) { o.frames.held_out_every = 1; });  // no training frames would remain
  refused([&](Options& o) { o.frames.held_out_every = -5; });
  refused([&](Options& o) { o.frames.image_scale = nan; });
  refused([&](Options& o) { o.frames.image_scale = 2.0; });
  refused([&](Options& o) { o.init.camera_sh_degree = 4; });
  refused([&](Options& o) { o.init.off_path_m = 101.0; });
}

TEST_F(InitializeScene, PictureOfAnotherSizeIsAnInputError) {
  write_image(log_.folder / log_.images[0].file, Image(40, 30, 3));
  try {
    (void)initialize_scene(log_, kFullSize, {});
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find("40 x 30"), std::string::npos) << error.what();
  }
}

/// Sensor motion and spin are compensated: points of a street, swept in motion, are on its surfaces.
TEST(InitializeStreet, PointsLieOnTheSurfacesOfTheStreet) {
  std::string pattern = (fs::temp_directory_path() / "simuli_init_street_XXXXXX").string();
  ASSERT_NE(mkdtemp(pattern.data()), nullptr);
  StreetOptions street_options;
  street_options.output = fs::path(pattern) / "street.log";
  street_options.frames = 3;
  street_options.image_width = 64;
  street_options.image_height = 36;
  street_options.lidar_columns = 180;
  street_options.moving_car = false;
  street_options.rolling_shutter = true;
  const Log log = synth_street(street_options);
  const SceneInit init = initialize_scene(log, kFullSize, {});
  const GaussianSet& set = init.scene.lidar;
  ASSERT_GT(set.size(), 500);
  // Surfaces that face the motion reveal errors: points moved along the road leave them. From the rig's
  // middle position, most of their particles are on the first surface; the others are occluded.
  const Street street({.seed = street_options.seed});
  const LogLidar& lidar = log.lidars.front();
  const Eigen::Vector3d eye = (log.world_from_rig.at(0.15) * lidar.rig_from_lidar).translation;
  const Eigen::Vector3d drive =
      (log.world_from_rig.at(0.3).translation - log.world_from_rig.at(0.0).translation).normalized();
  std::vector<double> off_m;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const Eigen::Vector3d p_world = init.scene.origin + set.mean().row(i).transpose().cast<double>();
    const double range_m = (p_world - eye).norm();
    const StreetHit hit = street.trace(eye, (p_world - eye) / range_m, 0.15, 200.0);
    if (!hit.hit || !(std::abs(hit.normal.dot(drive)) > 0.7)) continue;
    off_m.push_back(std::abs(hit.range - range_m) * std::abs(hit.normal.dot(p_world - eye)) / range_m);
  }
  ASSERT_GT(off_m.size(), 100U);
  std::nth_element(off_m.begin(), off_m.begin() + static_cast<long>(off_m.size() / 2), off_m.end());
  // The sensor's noise and the voxel's mean; without motion compensation (0.8 m per sweep) the error is
  // decimetres.
  EXPECT_LT(off_m[off_m.size() / 2], 0.03);
  fs::remove_all(pattern);
}

}  // namespace
}  // namespace simuli
