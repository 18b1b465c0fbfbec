#pragma once
// What answers about scenes and about logs are made of.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "host/device/render/scene/readings.hpp"
#include "host/device/render/scene/shot.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/frame_spans.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

inline constexpr int kJpegQuality = 90;

[[nodiscard]] Json json_of(const Eigen::Vector3d& v);
[[nodiscard]] Json json_of(const Pose& pose);
/// Of two parts, as ViewAnswers::picture() has them.
[[nodiscard]] std::string reply(const Json& info, const void* payload, std::size_t bytes);

/// Names of its cameras and LiDARs, starts and ends of their frames by name, poses of the rig in the scene's
/// frame, where it begins and ends; of cameras the mounting and directions (camera frame, unit) around the edge
/// of the picture.
[[nodiscard]] Json json_of_drive(const std::vector<LogCamera>& cameras,
                                 const std::vector<LogLidar>& lidars,
                                 const Trajectory& world_from_rig,
                                 const FrameSpans& frames,
                                 const Eigen::Vector3d& origin);
/// Name, kind and size of each.
[[nodiscard]] Json json_of_actors(const std::vector<Actor>& actors);
/// Where the actors are, in the scene's frame.
[[nodiscard]] Json json_of_boxes(const std::vector<Actor>& actors, const std::vector<ActorView>& views);
/// Edges of the boxes as the camera sees them, with its shutter: [{"name", "lines": [[x, y, x, y, ...]]}], in
/// parts of the picture's sides.
[[nodiscard]] Json json_of_outlines(const Camera& camera,
                                    const Shot& in_scene,
                                    const std::vector<Actor>& actors,
                                    const std::vector<ActorView>& views);

/// Values of one return in ViewAnswers::sweep().
inline constexpr std::size_t kPointValues = 7;
/// Appends the returns of a sweep, each `every`-th.
void append_points(const LidarModel& lidar,
                   const LidarFrame& frame,
                   const Shot& in_scene,
                   const std::vector<Actor>& actors,
                   const std::vector<ActorView>& views,
                   std::size_t every,
                   std::vector<float>& points);

/// Values of one return in ViewAnswers::picture(): x and y in parts of the picture's sides behind those above.
inline constexpr std::size_t kSeenValues = kPointValues + 2;
/// Those of the points that the camera's shutter sees where they lay when they were measured.
[[nodiscard]] std::vector<float> seen_points(const Camera& camera,
                                             const Shot& in_scene,
                                             const std::vector<float>& points);
/// `points`, then the picture's bytes.
[[nodiscard]] std::string with_points(const std::vector<float>& points, const std::string& picture);

}  // namespace simuli::cli
