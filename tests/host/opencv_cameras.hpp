#pragma once
// The conformance file of cameras and points projected by OpenCV, in the folder $SIMULI_DATA.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "host/core/sensors/camera.hpp"

namespace simuli::test {

// The file gives fold angles of the radial terms in steps of 0.01; tangential terms bend the fold by up to
// a fifth of a degree.
inline constexpr double kFoldRounding_deg = 0.3;

struct OpencvCamera {
  Camera camera;  // principal point moved by half a pixel, to our convention
  double fold_deg = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3d> points;  // m
  std::vector<Eigen::Vector2d> pixels;  // in our convention

  [[nodiscard]] double off_axis_deg(std::size_t i) const {
    return std::atan2(points[i].head<2>().norm(), points[i].z()) * 180.0 / std::numbers::pi;
  }
};

/// Returns the cameras; empty without SIMULI_DATA.
inline std::vector<OpencvCamera> opencv_cameras() {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) return {};
  std::ifstream stream(std::filesystem::path(data) / "conformance" / "camera_projection_opencv.json");
  const auto root = nlohmann::json::parse(stream);
  constexpr double kNoLimit = std::numbers::pi;
  std::vector<OpencvCamera> all;
  for (const auto& entry : root["cases"]) {
    OpencvCamera c;
    c.camera.name = entry["camera"];
    if (entry.contains("params")) {
      const auto& p = entry["params"];
      c.camera.fx = p["gamma1"];
      c.camera.fy = p["gamma2"];
      c.camera.cx = p["u0"];
      c.camera.cy = p["v0"];
      c.camera.lens = Lens(LensKind::kMei, {p["k1"], p["k2"], p["p1"], p["p2"], p["xi"], kNoLimit});
    } else {
      c.camera.fx = entry["K"][0][0];
      c.camera.fy = entry["K"][1][1];
      c.camera.cx = entry["K"][0][2];
      c.camera.cy = entry["K"][1][2];
      for (const char* const key : {"dist_k1k2p1p2k3", "dist_k1k2p1p2k3k4k5k6s1s2s3s4", "dist_k1k2k3k4"}) {
        if (!entry.contains(key)) continue;
        std::vector<double> parameters = entry[key];
        const bool fisheye = std::string(key) == "dist_k1k2k3k4";
        if (!fisheye) parameters.resize(12, 0.0);
        parameters.push_back(kNoLimit);
        c.camera.lens = Lens(fisheye ? LensKind::kOpencvFisheye : LensKind::kOpencvPinhole, parameters);
      }
    }
    c.camera.cx += 0.5;
    c.camera.cy += 0.5;
    if (entry.contains("radial_fold_angle_deg") && !entry["radial_fold_angle_deg"].is_null()) {
      c.fold_deg = entry["radial_fold_angle_deg"];
    }
    for (const auto& p : entry["xyz"]) c.points.emplace_back(p[0], p[1], p[2]);
    for (const auto& p : entry["uv"]) {
      c.pixels.emplace_back(p[0].get<double>() + 0.5, p[1].get<double>() + 0.5);
    }
    all.push_back(std::move(c));
  }
  return all;
}

}  // namespace simuli::test
