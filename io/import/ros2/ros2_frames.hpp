#pragma once
// Clouds and pictures of a recording as sweeps and pictures of a log. For io/import/ros2/*.cpp alone.
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "host/core/base/image.hpp"
#include "io/bag/bag.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "io/import/ros2/ros2_log.hpp"
#include "io/import/ros2/ros2_scan.hpp"

namespace simuli::ros2 {

struct RecordedCamera {
  std::string name;
  double readout_s = 0.0;
};

class FrameWriter {
 public:
  /// Frames that begin before `span` (nanoseconds since 1970) or end behind it are left out.
  FrameWriter(const Bag& bag,
              const std::string& file,
              Log& log,
              std::pair<std::int64_t, std::int64_t> span,
              Ros2Report& report);

  /// Adds the frames to the log by their stamps alone.
  void survey(const Scan& scan,
              const std::map<std::string, RecordedLidar>& lidars,
              const std::map<std::string, RecordedCamera>& cameras);
  /// In one pass, by topic; adds the frames to the log. Damaged messages are left out and noted, unless a topic has
  /// no others. Errors as import_ros2().
  void write(const std::map<std::string, RecordedLidar>& lidars,
             const std::map<std::string, RecordedCamera>& cameras,
             const CloudFieldOptions& fields,
             const FrameProgress& progress);

  /// How many frames there are.
  std::size_t total = 0;

 private:
  /// Whether `read` can read the message; what it throws is counted.
  [[nodiscard]] bool is_sound(const std::string& topic, const std::function<void()>& read);
  /// Neither beside the path nor a second one of that stamp; those are counted.
  [[nodiscard]] bool is_wanted(const std::string& sensor, double start_s, double end_s);
  [[nodiscard]] double seconds(std::int64_t stamp_ns) const;
  void add_cloud(const BagChannel& channel,
                 std::string_view data,
                 const RecordedLidar& lidar,
                 const CloudFieldOptions& options);
  void add_picture(const BagChannel& channel, std::string_view data, const RecordedCamera& camera);

  const Bag& bag_;
  const std::string& file_;
  Log& log_;
  std::pair<std::int64_t, std::int64_t> span_;
  Ros2Report& report_;
  std::map<std::string, Damage> damaged_;               // by topic
  std::set<std::pair<std::string, double>> are_there_;  // sensors and starts of frames
};

/// Of a picture's file, by its first bytes: ".png", ".jpg", ".webp", or "".
[[nodiscard]] std::string picture_ending(const CompressedImageMessage& message);
/// Whether picture_of() reads it.
[[nodiscard]] bool is_known_encoding(std::string_view encoding);

/// Error{kInput} naming `file` and `where` for another encoding than the line lists then: colours of 8 and 16
/// bits, Bayer's mosaics (each pixel lacks two colours: means of those beside it), YUV (BT.601).
[[nodiscard]] Image picture_of(const ImageMessage& message,
                               const std::string& file,
                               const std::string& where);

}  // namespace simuli::ros2
