#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/import/kitti360/kitti360_parts.hpp"

namespace simuli::kitti360 {
namespace {

namespace fs = std::filesystem;
using kitti::parse_numbers;

/// "key: values" lines of a file, with the file's name for messages.
class Keys {
 public:
  Keys(fs::path file, std::map<std::string, std::string> values)
      : file_(std::move(file)), values_(std::move(values)) {}

  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const {
    return parse_numbers(text(key), count, file_, key);
  }
  [[nodiscard]] const std::string& text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) throw_input_error(file_.string(), key, "no such key", "a value");
    return found->second;
  }
  [[nodiscard]] double number(const std::string& key) const { return numbers(key, 1).front(); }
  [[nodiscard]] int pixels(const std::string& key, double value) const {
    if (value >= 1.0 && value <= 65536.0 && value == std::floor(value)) return static_cast<int>(value);
    throw_input_error(file_.string(), key, fmt::format("{}", value), "whole pixels, 1 to 65536");
  }
  [[nodiscard]] std::string name() const { return file_.string(); }

 private:
  fs::path file_;
  std::map<std::string, std::string> values_;
};

Keys read_keys(const fs::path& file) { return {file, kitti::read_key_lines(file)}; }

/// 9 numbers are a rotation, 12 a rigid transform.
Pose pose_of(const std::vector<double>& v, const fs::path& file, const std::string& field) {
  Eigen::Matrix<double, 3, 4> m = Eigen::Matrix<double, 3, 4>::Zero();
  const Eigen::Index columns = v.size() == 9 ? 3 : 4;
  for (Eigen::Index r = 0; r < 3; ++r) {
    for (Eigen::Index c = 0; c < columns; ++c) m(r, c) = v[static_cast<std::size_t>(r * columns + c)];
  }
  return with_context("reading " + file.string() + ": " + field, [&] { return Pose::from_matrix(m); });
}

std::string without_blanks(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\"");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\"") - first + 1);
}

/// Reads "key: value" of all levels: keys of these files are unique.
Keys read_yaml(const fs::path& file) {
  std::map<std::string, std::string> values;
  for (const auto& [number, line] : kitti::numbered_lines(file)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || line.front() == '%') continue;  // lines --- and %YAML:1.0
    const std::string key = without_blanks(line.substr(0, colon));
    if (!values.emplace(key, without_blanks(line.substr(colon + 1))).second) {
      throw_input_error(file.string(), fmt::format("line {}", number), key + " twice", "each key once");
    }
  }
  return {file, std::move(values)};
}

/// Returns a rectified camera with its own K of P_rect; its mounting includes the pair's baseline.
Camera read_perspective(const Keys& keys, const std::string& name) {
  const std::string number = name.substr(name.size() - 2);
  const std::vector<double> size = keys.numbers("S_rect_" + number, 2);
  const std::vector<double> p = keys.numbers("P_rect_" + number, 12);
  Camera c;
  c.name = name;
  c.width = keys.pixels("S_rect_" + number, size[0]);
  c.height = keys.pixels("S_rect_" + number, size[1]);
  c.fx = p[0];
  c.fy = p[5];
  c.cx = p[2] + 0.5;  // principal points are relative to the centre of the first pixel
  c.cy = p[6] + 0.5;
  validate(c, keys.name());
  return c;
}

}  // namespace

Camera read_fisheye(const fs::path& file, const std::string& name) {
  const Keys keys = read_yaml(file);
  if (keys.text("model_type") != "MEI") {
    throw_input_error(file.string(), "model_type", keys.text("model_type").substr(0, 40), "MEI");
  }
  Camera c;
  c.name = name;
  c.width = keys.pixels("image_width", keys.number("image_width"));
  c.height = keys.pixels("image_height", keys.number("image_height"));
  c.fx = keys.number("gamma1");
  c.fy = keys.number("gamma2");
  c.cx = keys.number("u0") + 0.5;
  c.cy = keys.number("v0") + 0.5;
  std::vector<double> lens;
  for (const std::string& parameter : lens_parameter_names(LensKind::kMei)) {
    lens.push_back(parameter == "max_angle_rad" ? std::numbers::pi : keys.number(parameter));
  }
  c.lens = Lens(LensKind::kMei, lens, file.string());
  validate(c, file.string());
  return c;
}

Calibration read_calibration(const fs::path& folder, const std::vector<std::string>& cameras) {
  const fs::path to_velo = folder / "calib_cam_to_velo.txt", to_pose = folder / "calib_cam_to_pose.txt";
  const Keys imu_from = read_keys(to_pose);
  const auto imu_from_camera = [&](const std::string& name) {
    return pose_of(imu_from.numbers(name, 12), to_pose, name);
  };
  const Pose velo_from_image00 =
      pose_of(parse_numbers(read_file(to_velo, 1U << 16U), 12, to_velo, "matrix"), to_velo, "matrix");
  Calibration out;
  out.imu_from_velo = imu_from_camera("image_00") * velo_from_image00.inverse();
  const Pose velo_from_imu = out.imu_from_velo.inverse();
  for (const std::string& name : cameras) {
    LogCamera camera{{}, velo_from_imu * imu_from_camera(name)};
    if (name == "image_02" || name == "image_03") {
      camera.model = read_fisheye(folder / (name + ".yaml"), name);
    } else {
      const Keys keys = read_keys(folder / "perspective.txt");
      const std::string rectified = "R_rect_" + name.substr(name.size() - 2);
      camera.model = read_perspective(keys, name);
      camera.rig_from_camera =
          camera.rig_from_camera * pose_of(keys.numbers(rectified, 9), keys.name(), rectified).inverse();
    }
    out.cameras.push_back(std::move(camera));
  }
  return out;
}

std::map<std::size_t, Pose> read_poses(const fs::path& file) {
  constexpr double kMostFrames = 1e7;
  std::map<std::size_t, Pose> poses;
  for (const auto& [number, line] : kitti::numbered_lines(file)) {
    const std::string where = fmt::format("line {}", number);
    const std::vector<double> v = parse_numbers(line, 13, file, where);
    const bool rises = poses.empty() || v[0] > static_cast<double>(poses.rbegin()->first);
    if (!(v[0] >= 0.0 && v[0] <= kMostFrames && v[0] == std::floor(v[0]) && rises)) {
      throw_input_error(file.string(), where, fmt::format("frame {}", v[0]), "whole numbers that rise");
    }
    poses[static_cast<std::size_t>(v[0])] = pose_of({v.begin() + 1, v.end()}, file, where);
  }
  return poses;
}

}  // namespace simuli::kitti360
