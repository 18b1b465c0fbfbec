#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <numbers>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/photos/photo_log.hpp"
#include "io/splat/ply.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// Numbers of the frame, else of all frames.
class Intrinsics {
 public:
  Intrinsics(JsonObject& all, JsonObject& frame) : all_(all), frame_(frame) {}
  [[nodiscard]] bool has(const std::string& key) const { return frame_.has(key) || all_.has(key); }
  [[nodiscard]] double number(const std::string& key) {
    return frame_.has(key) ? frame_.number(key) : all_.number(key);
  }
  [[nodiscard]] bool boolean(const std::string& key) {
    return frame_.has(key) ? frame_.boolean(key) : all_.boolean(key);
  }
  [[nodiscard]] double number_or(const std::string& key, double other) {
    return has(key) ? number(key) : other;
  }
  [[nodiscard]] std::string text_or(const std::string& key, const std::string& other) {
    if (frame_.has(key)) return frame_.text(key);
    return all_.has(key) ? all_.text(key) : other;
  }

 private:
  JsonObject& all_;
  JsonObject& frame_;
};

int pixels(Intrinsics& of, const char* key, const std::string& file) {
  const double value = of.number(key);
  if (value >= 1.0 && value <= 65536.0 && value == std::floor(value)) return static_cast<int>(value);
  throw_input_error(file, key, fmt::format("{}", value), "a whole number from 1 to 65536");
}

/// Returns the focal length, from its key or from a side's field of view.
double focal_px(Intrinsics& of, const char* focal, const char* angle, int side, const std::string& file) {
  const bool is_angle = !of.has(focal);
  const double value = of.number(is_angle ? angle : focal);
  if (is_angle && value > 0.0 && value < std::numbers::pi) return 0.5 * side / std::tan(0.5 * value);
  if (!is_angle && value > 0.0) return value;
  throw_input_error(
      file, is_angle ? angle : focal, fmt::format("{}", value), is_angle ? "above 0, below pi" : "above 0");
}

Camera camera_of(Intrinsics& of, const std::string& file) {
  Camera c;
  c.width = pixels(of, "w", file);
  c.height = pixels(of, "h", file);
  c.fx = focal_px(of, "fl_x", "camera_angle_x", c.width, file);
  const bool has_vertical = of.has("fl_y") || of.has("camera_angle_y");
  c.fy = has_vertical ? focal_px(of, "fl_y", "camera_angle_y", c.height, file) : c.fx;
  c.cx = of.number_or("cx", 0.5 * c.width);
  c.cy = of.number_or("cy", 0.5 * c.height);
  // instant-ngp's key; its scripts write no camera_model.
  const bool is_fisheye = of.has("is_fisheye") && of.boolean("is_fisheye");
  const std::string model = of.text_or("camera_model", is_fisheye ? "OPENCV_FISHEYE" : "OPENCV");
  if (is_fisheye && model != "OPENCV_FISHEYE")
    throw_input_error(file, "is_fisheye", "true with camera_model " + model, "OPENCV_FISHEYE with it");
  const auto k = [&](const char* key) { return of.number_or(key, 0.0); };
  if (model == "OPENCV_FISHEYE") {
    c.lens = Lens(LensKind::kOpencvFisheye, {k("k1"), k("k2"), k("k3"), k("k4"), std::numbers::pi}, file);
  } else if (model == "PINHOLE" || model == "SIMPLE_PINHOLE" || model == "OPENCV" ||
             // as in nerfstudio: the coefficients determine the lens
             model == "SIMPLE_RADIAL" || model == "RADIAL") {
    std::vector<double> lens(lens_parameter_names(LensKind::kOpencvPinhole).size(), 0.0);
    if (k("k4") != 0.0)
      throw_input_error(file, "k4", fmt::format("{}", k("k4")), "0 with camera_model " + model);
    constexpr std::array kKeys{"k1", "k2", "p1", "p2", "k3"};
    for (std::size_t i = 0; i < kKeys.size(); ++i) lens[i] = k(kKeys[i]);
    const bool plain = std::all_of(lens.begin(), lens.end(), [](double value) { return value == 0.0; });
    lens.back() = std::numbers::pi;
    if (!plain) c.lens = Lens(LensKind::kOpencvPinhole, lens, file);
  } else {
    throw_input_error(file, "camera_model", '"' + model + '"', "PINHOLE, OPENCV or OPENCV_FISHEYE");
  }
  validate(c, file);
  return c;
}

bool same(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.lens == b.lens;
}

/// Returns the index of a camera in the set; adds new ones.
std::size_t camera_index(PhotoSet& set, Camera camera) {
  const auto known =
      std::find_if(set.cameras.begin(), set.cameras.end(), [&](const Camera& c) { return same(c, camera); });
  const auto index = static_cast<std::size_t>(known - set.cameras.begin());
  if (known != set.cameras.end()) return index;
  camera.name = fmt::format("camera_{}", index);
  set.cameras.push_back(std::move(camera));
  return index;
}

/// 3 or 4 rows of 4 with camera x right, y up, z back; this project's cameras look along z, y down.
Pose pose_of(const Json& rows, const std::string& file, const std::string& field) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  const auto refuse = [&](const char* found) {
    throw_input_error(file, field, found, "a 4 x 4 matrix, 0 0 0 1 the last row");
  };
  if (!rows.is_array() || rows.size() < 3 || rows.size() > 4) refuse("other rows");
  for (Eigen::Index r = 0; r < static_cast<Eigen::Index>(rows.size()); ++r) {
    const Json& row = rows[static_cast<std::size_t>(r)];
    if (!row.is_array() || row.size() != 4) refuse("other columns");
    for (Eigen::Index c = 0; c < 4; ++c) {
      const Json& value = row[static_cast<std::size_t>(c)];
      if (!value.is_number()) refuse("no number");
      m(r, c) = value.get<double>();
    }
  }
  constexpr double kSlack = 1e-5;  // for single precision
  if (!m.row(3).isApprox(Eigen::RowVector4d::UnitW(), kSlack)) refuse("another last row (is it transposed?)");
  m.col(1) = -m.col(1);
  m.col(2) = -m.col(2);
  return with_context("reading " + file + ": " + field, [&] { return Pose::from_matrix(m.topRows<3>()); });
}

fs::path photo_file(const fs::path& folder, JsonObject& frame) {
  fs::path name(frame.text("file_path"));
  if (!name.has_extension()) name += ".png";  // Blender's sets omit the extension
  return inside(folder, name, frame.file(), frame.field("file_path"));
}

}  // namespace

PhotoSet read_nerfstudio(const NerfstudioOptions& options) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(options.transforms, ignored) ? options.transforms / "transforms.json"
                                                                      : options.transforms;
  const fs::path folder = file.parent_path();
  PhotoSet set;
  set.source = file.string();
  read_json_text(read_file(file), set.source, [&](JsonObject& root) {
    root.ignore_other_keys();
    for (const char* lens : {"latlong", "ftheta_p0"}) {  // unsupported lenses of instant-ngp
      if (root.has(lens))
        throw_input_error(set.source, lens, "there", "PINHOLE, OPENCV or OPENCV_FISHEYE, by camera_model");
    }
    constexpr std::array kMoved{"rolling_shutter",
                                "rolling_shutter_time",
                                "exposure_time",
                                "transform_matrix_start",
                                "transform_matrix_end",
                                "camera_linear_velocity",
                                "camera_angular_velocity"};
    std::set<std::string> moved;
    std::size_t masked = 0, with_depth = 0;
    (void)root.objects("frames", [&](JsonObject& frame) {
      frame.ignore_other_keys();
      Intrinsics intrinsics(root, frame);
      const std::size_t camera = camera_index(set, camera_of(intrinsics, set.source));
      const Pose pose = pose_of(frame.get("transform_matrix"), set.source, frame.field("transform_matrix"));
      set.photos.push_back({photo_file(folder, frame), camera, pose});
      masked += frame.has("mask_path") ? 1U : 0U;
      with_depth += frame.has("depth_file_path") ? 1U : 0U;
      std::copy_if(kMoved.begin(), kMoved.end(), std::inserter(moved, moved.end()), [&](const char* key) {
        return intrinsics.has(key);
      });
      return 0;
    });
    if (masked > 0) {
      set.notes.push_back(fmt::format(
          "{} masks of single photographs are left out; simuli mask hides what a camera always sees",
          masked));
    }
    if (with_depth > 0) {
      set.notes.push_back(
          fmt::format("{} depth pictures are left out; points of ply_file_path are used", with_depth));
    }
    if (!moved.empty()) {
      set.notes.push_back(
          fmt::format("{} left out: each photograph counts as taken in one moment, at transform_matrix",
                      fmt::join(moved, ", ")));
    }
    if (root.has("ply_file_path")) {
      set.points = read_points_ply(inside(folder, root.text("ply_file_path"), set.source, "ply_file_path"));
    }
  });
  // Sorted by name, because files are not always in recording order.
  std::stable_sort(set.photos.begin(), set.photos.end(), [](const Photo& a, const Photo& b) {
    return is_before(a.file.string(), b.file.string());
  });
  return set;
}

Log import_nerfstudio(const NerfstudioOptions& options, const FrameProgress& progress, PhotoReport& report) {
  return write_photo_log(read_nerfstudio(options), options.metres_per_unit, options.output, progress, report);
}

}  // namespace simuli
