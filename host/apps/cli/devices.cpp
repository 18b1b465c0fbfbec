#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/core/base/error.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli::cli {
namespace {

constexpr double kOpacity = 0.6;
constexpr double kDistance_m = 20.0;
/// Float errors of polynomials of exp and of distances of tens of metres are a few 1e-6 of the value.
constexpr double kTolerance = 1e-4;

/// Returns one particle straight ahead at kDistance_m; the ray through its centre has its full opacity.
GaussianSet test_set(SetKind kind) {
  GaussianSet set(kind, 0, 1);
  set.mean().row(0) << (kind == SetKind::kLidar ? static_cast<float>(kDistance_m) : 0.0F), 0.0F,
      (kind == SetKind::kCamera ? static_cast<float>(kDistance_m) : 0.0F);
  set.log_scale().row(0).setConstant(std::log(0.5F));
  set.rotation().row(0) << 1.0F, 0.0F, 0.0F, 0.0F;
  set.opacity_logit()(0) = static_cast<float>(std::log(kOpacity / (1.0 - kOpacity)));
  set.sh(0).row(0) << 0.3F / kSh0, -0.2F / kSh0, 0.1F / kSh0;
  return set;
}

Scene test_scene() {
  Scene scene;
  scene.camera = test_set(SetKind::kCamera);
  scene.lidar = test_set(SetKind::kLidar);
  scene.camera_background = {0.25F, 0.5F, 1.0F};
  return scene;
}

/// Returns the largest deviation of the central ray from the blending formula.
double camera_error(SceneOnDevice& scene) {
  Camera camera;
  camera.name = "check";
  camera.width = camera.height = 33;  // odd: the central pixel points straight ahead
  camera.fx = camera.fy = 40.0;
  camera.cx = camera.cy = 16.5;
  const Frame frame = scene.render(Sensor(camera), {});
  const RayResults& r = frame.results();
  const std::size_t centre = 16 * 33 + 16;
  const double left = 1.0 - kOpacity;
  const std::array<double, 5> expected = {kOpacity * 0.8 + left * 0.25,
                                          kOpacity * 0.3 + left * 0.5,
                                          kOpacity * 0.6 + left * 1.0,
                                          left,
                                          kOpacity * kDistance_m};
  const std::array<float, 5> found = {r.feature[0][centre],
                                      r.feature[1][centre],
                                      r.feature[2][centre],
                                      r.transmittance[centre],
                                      r.distance[centre]};
  double worst = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    // A comparison that treats NaN as an error.
    const double error = std::abs(static_cast<double>(found[i]) - expected[i]) / std::max(1.0, expected[i]);
    worst = error <= worst ? worst : error;
  }
  return worst;
}

double lidar_error(SceneOnDevice& scene) {
  Lidar lidar;
  lidar.name = "check";
  for (const double elevation : {0.02, 0.0, -0.02}) {
    LidarRow row;
    row.elevation = elevation;
    lidar.rows.push_back(row);
  }
  lidar.columns = 90;
  lidar.azimuth_first = -3.1415926535897931;
  lidar.azimuth_span = 6.2831853071795862;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  LidarRays nominal = nominal_rays(lidar);
  const std::size_t ahead = 90 + 45;
  nominal.azimuth[ahead] = 0.0F;
  const Frame frame = scene.render(Sensor(lidar).with_rays(nominal), {});
  const RayResults& r = frame.results();
  const double intensity = std::abs(static_cast<double>(r.feature[0][ahead]) - kOpacity * 0.8);
  const double distance = std::abs(static_cast<double>(r.expected_distance(ahead)) / kDistance_m - 1.0);
  return distance <= intensity ? intensity : distance;
}

struct Check {
  bool passed = false;
  std::string text;
};

/// Renders one particle with a camera and a LiDAR, in float and, if the device supports it, in double.
Check check_device(std::size_t index) {
  try {
    const Device device = Device::best(std::to_string(index));
    double worst = 0.0;
    for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
      if (precision == Precision::kDouble && !device.info().fp64) continue;
      RenderOptions options;
      options.precision = precision;
      SceneOnDevice scene(device, test_scene(), options);
      for (const double error : {camera_error(scene), lidar_error(scene)}) {
        worst = error <= worst ? worst : error;
      }
    }
    return {worst <= kTolerance,
            fmt::format("largest error {:.2g}, allowed {:.2g}; {}",
                        worst,
                        kTolerance,
                        device.info().fp64 ? "float and double" : "float")};
  } catch (const Error& error) {
    return {false, error.what()};
  }
}

nlohmann::ordered_json device_json(std::size_t index, const DeviceInfo& d) {
  return {{"index", index},
          {"platform", d.platform},
          {"name", d.name},
          {"vendor", d.vendor},
          {"device_version", d.device_version},
          {"driver_version", d.driver_version},
          {"compute_units", d.compute_units},
          {"global_bytes", d.global_bytes},
          {"max_alloc_bytes", d.max_alloc_bytes},
          {"local_bytes", d.local_bytes},
          {"double_precision", d.fp64},
          {"kind",
           d.is_gpu   ? "gpu"
           : d.is_cpu ? "cpu"
                      : "other"},
          {"usable", d.usable}};
}

std::string device_text(std::size_t index, const DeviceInfo& d) {
  return fmt::format(
      "{}  {}\n   {}, driver {}, {} compute units, {:.1f} GB ({:.1f} GB in one buffer), {}{}\n",
      index,
      d.label(),
      d.device_version,
      d.driver_version,
      d.compute_units,
      static_cast<double>(d.global_bytes) / 1e9,
      static_cast<double>(d.max_alloc_bytes) / 1e9,
      d.fp64 ? "double precision" : "no double precision",
      d.usable ? "" : ", not usable");
}

void devices(bool check, const Globals& globals) {
  const std::vector<DeviceInfo> all = Device::list();
  if (all.empty()) {
    throw Error(ErrorKind::kDevice,
                "devices: found none, allowed any with an OpenCL 1.2 driver (for example PoCL)");
  }
  if (!globals.device.empty()) {  // throws for an unknown name, like every command
    for (const std::string& device : devices_of(globals.device)) static_cast<void>(Device::best(device));
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::string failed;
  for (std::size_t i = 0; i < all.size(); ++i) {
    nlohmann::ordered_json json = device_json(i, all[i]);
    std::string text = device_text(i, all[i]);
    if (check && all[i].usable) {
      const Check result = check_device(i);
      json["check_passed"] = result.passed;
      json["check"] = result.text;
      text += fmt::format("   check {}: {}\n", result.passed ? "passed" : "FAILED", result.text);
      if (!result.passed) failed += fmt::format("{}{}", failed.empty() ? "" : ", ", all[i].label());
    }
    if (!globals.json) std::cout << text;
    list.push_back(std::move(json));
  }
  if (globals.json) std::cout << json_text(list) << '\n';
  if (!failed.empty()) throw Error(ErrorKind::kDevice, "devices: check failed on " + failed);
}

}  // namespace

void add_devices(Command app, const Globals& globals) {
  const auto check = std::make_shared<bool>(false);
  Command sub = app.command("devices", "list OpenCL devices and their properties");
  sub.flag("--check", *check, "render a scene with a known result on each device and compare");
  sub.run([check, &globals] { devices(*check, globals); });
}

}  // namespace simuli::cli
