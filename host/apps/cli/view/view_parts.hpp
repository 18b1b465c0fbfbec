#pragma once
// Parts of answers that scenes and logs share.
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
/// Returns a reply of two parts as in ViewAnswers::picture().
[[nodiscard]] std::string reply(const Json& info, const void* payload, std::size_t bytes);

/// Returns names of cameras and LiDARs, start and end times of their frames by name, rig poses in the scene's
/// frame with first and last time, and for cameras the mounting and unit directions (camera frame) around the
/// picture's edge.
[[nodiscard]] Json json_of_drive(const std::vector<LogCamera>& cameras,
                                 const std::vector<LogLidar>& lidars,
                                 const Trajectory& world_from_rig,
                                 const FrameSpans& frames,
                                 const Eigen::Vector3d& origin);
/// Returns name, kind and size of each actor.
[[nodiscard]] Json json_of_actors(const std::vector<Actor>& actors);
/// Returns the actors' boxes in the scene's frame.
[[nodiscard]] Json json_of_boxes(const std::vector<Actor>& actors, const std::vector<ActorView>& views);
/// Returns the boxes' edges as the camera sees them with its shutter: [{"name", "lines": [[x, y, x, y, ...]]}],
/// as shares of the picture's sides.
[[nodiscard]] Json json_of_outlines(const Camera& camera,
                                    const Shot& in_scene,
                                    const std::vector<Actor>& actors,
                                    const std::vector<ActorView>& views);

/// Values per return in ViewAnswers::sweep().
inline constexpr std::size_t kPointValues = 7;
/// Appends each `every`-th return of a sweep.
void append_points(const LidarModel& lidar,
                   const LidarFrame& frame,
                   const Shot& in_scene,
                   const std::vector<Actor>& actors,
                   const std::vector<ActorView>& views,
                   std::size_t every,
                   std::vector<float>& points);

/// Values per return in ViewAnswers::picture(): those of a sweep, then x and y as shares of the picture's
/// sides.
inline constexpr std::size_t kSeenValues = kPointValues + 2;
/// Returns the points inside the picture: each projected with the camera's shutter from its measured position.
[[nodiscard]] std::vector<float> seen_points(const Camera& camera,
                                             const Shot& in_scene,
                                             const std::vector<float>& points);
/// Returns `points` followed by the picture's bytes.
[[nodiscard]] std::string with_points(const std::vector<float>& points, const std::string& picture);

}  // namespace simuli::cli
