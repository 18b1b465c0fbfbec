#pragma once
// What a PandaSet sequence's files hold. For io/import/pandaset/*.cpp and tests.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/import/pandaset/data_frame.hpp"
#include "io/import/pandaset/pandaset.hpp"

namespace simuli::pandaset {

/// Where the sensors are on the vehicle, whose rig is the Pandar64 turned to drive along x.
[[nodiscard]] Pose camera_from_pandar64();  // the front camera
[[nodiscard]] Pose pandar64_from_pandargt();
[[nodiscard]] Pose rig_from_pandar64();

/// Column d of the points.
enum class PointSource { kPandar64 = 0, kPandarGt = 1 };

/// Poses of a sensor in the data set's world, one per frame.
struct Posed {
  std::vector<std::int64_t> times_ns;  // rising
  std::vector<Pose> poses;             // world_from_sensor
};
/// poses.json and timestamps.json of a folder. Error{kInput} for other counts than each other's, and for times
/// that do not rise.
[[nodiscard]] Posed read_posed(const std::filesystem::path& folder);

/// Points of one LiDAR in one frame.
struct PointFrame {
  std::vector<Eigen::Vector3d> position;  // m, in the log's world
  std::vector<float> intensity;           // 0 to 1
  std::vector<double> time_s;             // of the log

  [[nodiscard]] bool empty() const { return position.empty(); }
  [[nodiscard]] double first_s() const;
  [[nodiscard]] double last_s() const;
};

/// Where a sequence stands: its frames of reference and times.
struct Frame {
  Pose world_from_theirs;
  std::int64_t start_ns = 0;

  [[nodiscard]] double seconds(std::int64_t ns) const { return static_cast<double>(ns - start_ns) * 1e-9; }
};

/// The points of a frame, by PointSource. Error{kInput} for values that no point has.
[[nodiscard]] std::map<PointSource, PointFrame> read_points(const std::filesystem::path& file,
                                                            const Frame& frame);

/// Boxes of all frames, one actor per object: a label of the PandarGT counts for the object that it names as
/// its sibling, where the Pandar64 has no label of that in the same frame.
class Boxes {
 public:
  /// The labels of one frame; `front_s`: when its points do not say it.
  void add(const DataFrame& labels,
           const std::string& file,
           const std::map<PointSource, PointFrame>& points,
           const Frame& frame,
           double front_s);
  /// By their first appearance, tracks by time, sizes the medians.
  [[nodiscard]] std::vector<Actor> take(const std::string& file, PandasetReport& report);

 private:
  LabelTracks tracks_;
  std::size_t twice_ = 0, by_front_ = 0;
};

}  // namespace simuli::pandaset
