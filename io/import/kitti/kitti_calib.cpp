#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

/// The files print 7 digits.
constexpr double kRotationTolerance = 1e-4;

/// One calibration file, read key by key.
class CalibrationFile {
 public:
  explicit CalibrationFile(fs::path file) : file_(std::move(file)), values_(read_key_lines(file_)) {}

  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const {
    const auto it = values_.find(key);
    if (it == values_.end()) {
      throw_input_error(file_.string(), key, "no such key", fmt::format("{} numbers", count));
    }
    return parse_numbers(it->second, count, file_, key);
  }

  [[nodiscard]] Eigen::Matrix3d rotation(const std::string& key) const {
    const std::vector<double> v = numbers(key, 9);
    const Eigen::Matrix3d r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
    const double off = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(off <= kRotationTolerance && r.determinant() > 0.0)) {
      throw_input_error(file_.string(),
                        key,
                        fmt::format("a matrix {:.3g} off a rotation", off),
                        fmt::format("a rotation within {}", kRotationTolerance));
    }
    return r;
  }

  /// Returns the rigid transform of the keys R and T.
  [[nodiscard]] Pose transform() const {
    Eigen::Matrix<double, 3, 4> m;
    m.leftCols<3>() = rotation("R");
    const std::vector<double> t = numbers("T", 3);
    m.col(3) = Eigen::Map<const Eigen::Vector3d>(t.data());
    return Pose::from_matrix(m);
  }

  [[nodiscard]] std::string name() const { return file_.string(); }

 private:
  fs::path file_;
  std::map<std::string, std::string> values_;
};

int whole_pixels(double size, const std::string& file, const std::string& key) {
  if (!(size >= 1.0 && size <= 65536.0 && size == std::floor(size))) {
    throw_input_error(file, key, fmt::format("{}", size), "whole pixels, 1 to 65536");
  }
  return static_cast<int>(size);
}

/// Returns the camera "image_NN"; the rig's frame is the velodyne's.
LogCamera read_camera(const CalibrationFile& file, const std::string& name, const Pose& rect00_from_velo) {
  const std::string number = name.substr(name.find('_') + 1);
  const std::string size_key = "S_rect_" + number, matrix_key = "P_rect_" + number;
  const std::vector<double> size = file.numbers(size_key, 2);
  const std::vector<double> p = file.numbers(matrix_key, 12);  // 3x4, row-major
  if (!(p[1] == 0.0 && p[4] == 0.0 && p[8] == 0.0 && p[9] == 0.0 && p[10] == 1.0 && p[0] > 0.0 &&
        p[5] > 0.0)) {
    throw_input_error(file.name(), matrix_key, "another form", "f 0 cx a 0 f cy b 0 0 1 c, f above 0");
  }
  Camera camera;
  camera.name = name;
  camera.width = whole_pixels(size[0], file.name(), size_key);
  camera.height = whole_pixels(size[1], file.name(), size_key);
  camera.fx = p[0];
  camera.fy = p[5];
  // KITTI's pixel (0, 0) has its centre at (0, 0), ours at (0.5, 0.5).
  camera.cx = p[2] + 0.5;
  camera.cy = p[6] + 0.5;
  validate(camera, file.name());
  // P_rect = K [1 | t]: the camera's centre is offset by t from the rectified frame of camera 0.
  Pose camera_from_velo = rect00_from_velo;
  camera_from_velo.translation +=
      Eigen::Vector3d((p[3] - p[2] * p[11]) / p[0], (p[7] - p[6] * p[11]) / p[5], p[11]);
  return {camera, camera_from_velo.inverse()};
}

}  // namespace

Calibration read_calibration(const fs::path& date_folder,
                             bool with_imu,
                             const std::vector<std::string>& cameras) {
  Calibration calibration;
  const CalibrationFile file(date_folder / "calib_cam_to_cam.txt");
  Eigen::Matrix<double, 3, 4> rect_from_cam00;
  rect_from_cam00 << file.rotation("R_rect_00"), Eigen::Vector3d::Zero();
  const Pose cam00_from_velo = CalibrationFile(date_folder / "calib_velo_to_cam.txt").transform();
  calibration.rect00_from_velo = Pose::from_matrix(rect_from_cam00) * cam00_from_velo;
  for (const std::string& name : cameras) {
    calibration.cameras.push_back(read_camera(file, name, calibration.rect00_from_velo));
  }
  if (with_imu) {
    calibration.velo_from_imu = CalibrationFile(date_folder / "calib_imu_to_velo.txt").transform();
  }
  return calibration;
}

}  // namespace simuli::kitti
