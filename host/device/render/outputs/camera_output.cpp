#include "host/device/render/outputs/camera_output.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/parallel.hpp"
#include "host/device/render/scene/frame_state.hpp"

namespace simuli {
namespace {

/// Unit directions of the pixels' rays in the camera frame, [height * width]; zero without a ray.
std::vector<Eigen::Vector3f> directions_of(const Frame& frame) {
  const RayGrid& grid = FrameAccess::grid(frame);
  const std::size_t slots = grid.frame.slots;
  std::vector<Eigen::Vector3f> out(grid.rays, Eigen::Vector3f::Zero());
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      out[static_cast<std::size_t>(ray)][static_cast<Eigen::Index>(k)] = grid.sensor_ray[k * slots + slot];
    }
  }
  return out;
}

std::vector<float> mean_distances(const RayResults& results) {
  std::vector<float> out(results.rays);
  for (std::size_t i = 0; i < results.rays; ++i) out[i] = results.expected_distance(i);
  return out;
}

const std::vector<float>& median_distances(const RayResults& results) {
  if (results.median.empty()) {
    throw Error(ErrorKind::kUsage,
                "distances: found a frame without medians, allowed one rendered with "
                "FrameRequest::camera_median");
  }
  return results.median;
}

std::vector<float> depths(const Frame& frame, std::vector<float> distances) {
  const std::vector<Eigen::Vector3f> directions = directions_of(frame);
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] *= directions[i].z();
  return distances;
}

std::vector<float> opacities(const RayResults& results) {
  std::vector<float> out(results.rays);
  for (std::size_t i = 0; i < results.rays; ++i) out[i] = 1.0F - results.transmittance[i];
  return out;
}

/// The visible surface of each pixel, for normals.
class Surface {
 public:
  explicit Surface(const Frame& frame)
      : camera_(frame.sensor().camera()),
        distances_(median_distances(frame.results())),
        directions_(directions_of(frame)) {}

  [[nodiscard]] Eigen::Vector3f normal(int x, int y) const {
    const std::size_t here = index(x, y);
    if (!(distances_[here] > 0.0F)) return Eigen::Vector3f::Zero();
    const Eigen::Vector3f middle = point(here);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
    float count = 0.0F;
    for (int v = std::max(y - kReach_px, 0); v <= std::min(y + kReach_px, camera_.height - 1); ++v) {
      for (int u = std::max(x - kReach_px, 0); u <= std::min(x + kReach_px, camera_.width - 1); ++u) {
        const std::size_t other = index(u, v);
        if (!(std::abs(distances_[other] - distances_[here]) <= kLargestStep * distances_[here])) continue;
        const Eigen::Vector3f way = point(other) - middle;
        sum += way;
        squares += way * way.transpose();
        count += 1.0F;
      }
    }
    const Eigen::Matrix3d spread = (squares / count - sum * sum.transpose() / (count * count)).cast<double>();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
    axes.computeDirect(spread);
    // Collinear pixels do not determine a plane.
    if (!(axes.eigenvalues()[1] > kNarrowest * axes.eigenvalues()[2])) return Eigen::Vector3f::Zero();
    const Eigen::Vector3f n = axes.eigenvectors().col(0).cast<float>();
    return n.dot(middle) > 0.0F ? Eigen::Vector3f(-n) : n;
  }

 private:
  static constexpr int kReach_px = 3;
  static constexpr float kLargestStep = 0.1F;  // relative distance step within a surface
  static constexpr double kNarrowest = 1e-6;

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] Eigen::Vector3f point(std::size_t pixel) const {
    return distances_[pixel] * directions_[pixel];
  }

  const Camera& camera_;
  const std::vector<float>& distances_;
  std::vector<Eigen::Vector3f> directions_;
};

Image normals(const Frame& frame) {
  const Surface surface(frame);
  Image out(frame.sensor().camera().width, frame.sensor().camera().height, 3);
  const auto width = static_cast<std::size_t>(out.width);
  parallel_each(width * static_cast<std::size_t>(out.height), [&](std::size_t i) {
    const auto x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    const Eigen::Vector3f n = surface.normal(x, y);
    for (int c = 0; c < 3; ++c) out.at(x, y, c) = n[c];
  });
  return out;
}

std::vector<float> values_of(const Frame& frame, CameraOutput output) {
  const RayResults& results = frame.results();
  switch (output) {
    case CameraOutput::kDepth:
      return depths(frame, median_distances(results));
    case CameraOutput::kMeanDepth:
      return depths(frame, mean_distances(results));
    case CameraOutput::kDistance:
      return median_distances(results);
    case CameraOutput::kMeanDistance:
      return mean_distances(results);
    case CameraOutput::kOpacity:
      return opacities(results);
    default:
      break;
  }
  const std::vector<std::uint32_t> actors = frame.actors();
  return {actors.begin(), actors.end()};
}

}  // namespace

const std::vector<std::string>& camera_output_names() {
  static const std::vector<std::string> names{"rgb",
                                              "depth",
                                              "mean_depth",
                                              "distance",
                                              "mean_distance",
                                              "opacity",
                                              "actors",
                                              "normals",
                                              "support",
                                              "flow",
                                              "scene_flow"};
  return names;
}

CameraOutput camera_output(std::string_view name) {
  return static_cast<CameraOutput>(index_of_name(name, camera_output_names(), "output"));
}

FrameRequest request_for(const std::vector<CameraOutput>& outputs, FrameRequest request) {
  for (const CameraOutput output : outputs) {
    const bool is_flow = output == CameraOutput::kFlow || output == CameraOutput::kSceneFlow;
    request.camera_median |= output == CameraOutput::kDepth || output == CameraOutput::kDistance ||
                             output == CameraOutput::kNormals || is_flow;
    request.actors |= output == CameraOutput::kActors || is_flow;
  }
  return request;
}

Image image_of(const Frame& frame, CameraOutput output) {
  const Camera& camera = frame.sensor().camera();
  if (output == CameraOutput::kRgb) return frame.image();
  if (output == CameraOutput::kNormals) return normals(frame);
  if (output == CameraOutput::kSupport) {
    throw Error(
        ErrorKind::kUsage,
        "support: found a frame alone, allowed with the record of its scene: SupportOnDevice::image_of()");
  }
  if (output == CameraOutput::kFlow || output == CameraOutput::kSceneFlow)
    throw Error(ErrorKind::kUsage, "flow: found a frame alone, allowed with another shot: flow_of()");
  Image image(camera.width, camera.height, 1);
  image.data = values_of(frame, output);
  return image;
}

}  // namespace simuli
