#include "bench/render/agreement.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <map>

#include "bench/particles/particle_street.hpp"
#include "bench/render/scene.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/lidar.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli::bench {
namespace {

constexpr std::int64_t kParticles = 200'000;
constexpr double kSameBits_dB = 200.0;
constexpr char kMagic[] = "simuli agreement 1\n";

/// Values per ray: three features, transmittance, expected distance (m).
constexpr std::size_t kValues = 5;
using Picture = std::vector<float>;  // [rays][kValues]

Picture picture_of(const RayResults& results) {
  Picture picture;
  picture.reserve(results.rays * kValues);
  for (std::size_t ray = 0; ray < results.rays; ++ray) {
    for (const auto& channel : results.feature) picture.push_back(channel[ray]);
    picture.push_back(results.transmittance[ray]);
    picture.push_back(results.expected_distance(ray));
  }
  return picture;
}

Picture render(const Device& device, SetKind kind, Precision precision) {
  RenderOptions options = paper_options();
  options.precision = precision;
  Scene street;
  (kind == SetKind::kCamera ? street.camera : street.lidar) = street_particles(kind, 3, kParticles, 1);
  street.lidar_background = {0.0F, 0.0F, 0.0F};
  SceneOnDevice scene(device, std::move(street), options);
  // Motion of 15 m/s and 30 degrees/s for 20 and 100 ms.
  Camera camera = bench_camera();
  camera.shutter = ShutterKind::kTopToBottom;
  const Sensor sensor =
      kind == SetKind::kCamera ? Sensor(camera, {}, 0.02) : Sensor(builtin_lidar("generic64"));
  const double seconds = sensor.duration_s();
  const Pose start = world_from_bench_sensor(kind);
  const Eigen::AngleAxisd turn(0.5236 * seconds, Eigen::Vector3d::UnitZ());
  Pose end = start;
  end.translation.x() += 15.0 * seconds;
  end.rotation = Eigen::Quaterniond(turn) * start.rotation;
  return picture_of(scene.render(sensor, {start, end}).results());
}

/// Returns the larger error; NaN counts as the largest.
double larger(double worst, double error) { return error <= worst ? worst : error; }

void compare_cameras(const std::string& base, const Picture& a, const Picture& b, std::vector<Row>& rows) {
  double squares = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (i % kValues >= 3) continue;
    const double error = std::abs(std::clamp(static_cast<double>(a[i]), 0.0, 1.0) -
                                  std::clamp(static_cast<double>(b[i]), 0.0, 1.0));
    squares += error * error;
    largest = larger(largest, error);
  }
  const double mean = squares / (static_cast<double>(a.size() / kValues) * 3.0);
  rows.push_back({base + "/psnr", mean == 0.0 ? kSameBits_dB : -10.0 * std::log10(mean), "dB", 0.0});
  rows.push_back({base + "/largest", largest, "of 1", 0.0});
}

void compare_lidars(const std::string& base, const Picture& a, const Picture& b, std::vector<Row>& rows) {
  std::vector<double> errors;
  std::size_t otherwise = 0;
  for (std::size_t i = 0; i < a.size(); i += kValues) {
    const bool hit_a = a[i + 3] < 0.5F, hit_b = b[i + 3] < 0.5F;
    otherwise += hit_a != hit_b ? 1 : 0;
    if (!hit_a || !hit_b) continue;
    const double error = std::abs(static_cast<double>(a[i + 4]) - static_cast<double>(b[i + 4]));
    errors.push_back(error >= 0.0 ? error : std::numeric_limits<double>::infinity());
  }
  std::sort(errors.begin(), errors.end());
  const double rays = static_cast<double>(a.size() / kValues);
  rows.push_back({base + "/hit_otherwise", static_cast<double>(otherwise) / rays, "", 0.0});
  if (errors.empty()) return;
  rows.push_back({base + "/range_p99", errors[(errors.size() - 1) * 99 / 100], "m", 0.0});
  rows.push_back({base + "/range_largest", errors.back(), "m", 0.0});
}

void compare(const std::string& name,
             const std::string& with,
             const Picture& a,
             const Picture& b,
             std::vector<Row>& rows) {
  const std::string base = fmt::format("agreement/{}_{}", name, with);
  std::size_t other = 0;
  for (std::size_t i = 0; i < a.size(); i += kValues) {
    const auto ray = static_cast<std::ptrdiff_t>(i);
    other += std::equal(a.begin() + ray, a.begin() + ray + kValues, b.begin() + ray) ? 0 : 1;
  }
  const double share = static_cast<double>(other) / static_cast<double>(a.size() / kValues);
  rows.push_back({base + "/rays_of_other_bits", share, "", 0.0});
  (name == "camera" ? compare_cameras : compare_lidars)(base, a, b, rows);
}

/// Results by name, for example "camera_float".
using Pictures = std::map<std::string, Picture>;

void write(const std::string& file, const Pictures& pictures) {
  std::ofstream out(file, std::ios::binary);
  out << kMagic;
  for (const auto& [name, picture] : pictures) {
    out << name << ' ' << picture.size() << '\n';
    out.write(reinterpret_cast<const char*>(picture.data()),
              static_cast<std::streamsize>(picture.size() * sizeof(float)));
  }
  out.close();
  if (!out) throw Error(ErrorKind::kInput, file + ": can't be written");
}

/// Reads the results in `file` that have the sizes of `like`.
Pictures read(const std::string& file, const Pictures& like) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line + '\n' != kMagic) {
    throw Error(ErrorKind::kInput, file + ": found no pictures, allowed a file of bench --agreement");
  }
  Pictures pictures;
  std::string name;
  std::size_t values = 0;
  while (in >> name >> values) {
    const auto mine = like.find(name);
    const std::size_t allowed = mine == like.end() ? values : mine->second.size();
    if (values != allowed || values > (std::size_t{1} << 28U)) {
      throw Error(ErrorKind::kInput,
                  fmt::format("{}: {}: found {} values, allowed {}", file, name, values, allowed));
    }
    in.get();
    Picture picture(values);
    in.read(reinterpret_cast<char*>(picture.data()), static_cast<std::streamsize>(values * sizeof(float)));
    if (!in) throw Error(ErrorKind::kInput, fmt::format("{}: {}: the file ends too early", file, name));
    pictures.emplace(name, std::move(picture));
  }
  return pictures;
}

}  // namespace

std::vector<Row> run_agreement(const std::string& device_request,
                               const std::string& file,
                               const std::function<void(const std::string&)>& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  Pictures mine;
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    const std::string name = kind == SetKind::kCamera ? "camera" : "lidar";
    mine[name + "_float"] = render(device, kind, Precision::kFloat);
    if (device.info().fp64) mine[name + "_double"] = render(device, kind, Precision::kDouble);
  }
  if (!std::filesystem::exists(file)) {
    write(file, mine);
    note(file + " was written");
  }
  const Pictures theirs = read(file, mine);
  std::vector<Row> rows;
  for (const char* sensor : {"camera", "lidar"}) {
    const std::string name(sensor);
    for (const char* precision : {"float", "double"}) {
      const auto a = mine.find(name + '_' + precision);
      const auto b = theirs.find(name + '_' + precision);
      if (a != mine.end() && b != theirs.end()) compare(name, precision, a->second, b->second, rows);
    }
    const auto exact = mine.find(name + "_double");
    if (exact != mine.end()) compare(name, "own_double", mine.at(name + "_float"), exact->second, rows);
  }
  return rows;
}

}  // namespace simuli::bench
