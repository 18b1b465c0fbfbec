#pragma once
// Content of a PandaSet sequence's files, for io/import/pandaset/*.cpp and tests.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/import/pandaset/data_frame.hpp"
#include "io/import/pandaset/pandaset.hpp"

namespace simuli::pandaset {

/// Mountings on the vehicle; the rig's frame is the Pandar64's, rotated such that the vehicle drives along x.
[[nodiscard]] Pose camera_from_pandar64();  // the front camera
[[nodiscard]] Pose pandar64_from_pandargt();
[[nodiscard]] Pose rig_from_pandar64();

/// Values of column d of the points.
enum class PointSource { kPandar64 = 0, kPandarGt = 1 };

/// Poses of a sensor in the data set's world frame, one per frame.
struct Posed {
  std::vector<std::int64_t> times_ns;  // increasing
  std::vector<Pose> poses;             // world_from_sensor
};
/// Reads poses.json and timestamps.json of a folder. Throws Error{kInput} for different lengths, and for times
/// that do not increase.
[[nodiscard]] Posed read_posed(const std::filesystem::path& folder);

/// Points of one LiDAR in one frame.
struct PointFrame {
  std::vector<Eigen::Vector3d> position;  // m, in the log's world frame
  std::vector<float> intensity;           // 0 to 1
  std::vector<double> time_s;             // of the log

  [[nodiscard]] bool empty() const { return position.empty(); }
  [[nodiscard]] double first_s() const;
  [[nodiscard]] double last_s() const;
};

/// Reference frame and time of a sequence.
struct Frame {
  Pose world_from_theirs;
  std::int64_t start_ns = 0;

  [[nodiscard]] double seconds(std::int64_t ns) const { return static_cast<double>(ns - start_ns) * 1e-9; }
};

/// Returns the points of a frame by PointSource. Throws Error{kInput} for invalid values.
[[nodiscard]] std::map<PointSource, PointFrame> read_points(const std::filesystem::path& file,
                                                            const Frame& frame);

/// Collects the boxes of all frames, one actor per object. A label of the PandarGT is assigned to its sibling
/// object, unless the Pandar64 has a label of that object in the same frame.
class Boxes {
 public:
  /// Adds the labels of one frame; `front_s`: the time of boxes without points.
  void add(const DataFrame& labels,
           const std::string& file,
           const std::map<PointSource, PointFrame>& points,
           const Frame& frame,
           double front_s);
  /// Returns actors in the order of their first appearance (LabelTracks::take()).
  [[nodiscard]] std::vector<Actor> take(const std::string& file, PandasetReport& report);

 private:
  LabelTracks tracks_;
  std::size_t twice_ = 0, by_front_ = 0;
};

}  // namespace simuli::pandaset
