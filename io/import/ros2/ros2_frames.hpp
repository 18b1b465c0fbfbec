#pragma once
// Conversion of a recording's clouds and pictures, for io/import/ros2/*.cpp.
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
  /// Leaves out frames that begin before `span` (nanoseconds since 1970) or end after it.
  FrameWriter(const Bag& bag,
              const std::string& file,
              Log& log,
              std::pair<std::int64_t, std::int64_t> span,
              Ros2Report& report);

  /// Adds the frames to the log by their stamps only.
  void survey(const Scan& scan,
              const std::map<std::string, RecordedLidar>& lidars,
              const std::map<std::string, RecordedCamera>& cameras);
  /// Writes the frames in one pass and adds them to the log. Damaged messages are left out and noted, unless a
  /// topic has no others. Errors as in import_ros2().
  void write(const std::map<std::string, RecordedLidar>& lidars,
             const std::map<std::string, RecordedCamera>& cameras,
             const CloudFieldOptions& fields,
             const FrameProgress& progress);

  /// Number of frames.
  std::size_t total = 0;

 private:
  /// Whether `read` can read the message; counts its errors.
  [[nodiscard]] bool is_sound(const std::string& topic, const std::function<void()>& read);
  /// Whether a frame is within the trajectory and the first with its stamp; counts the others.
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
  std::set<std::pair<std::string, double>> are_there_;  // sensors and start times of frames
};

/// Returns a picture's extension by its first bytes: ".png", ".jpg", ".webp", or "".
[[nodiscard]] std::string picture_ending(const CompressedImageMessage& message);
/// Whether picture_of() supports the encoding.
[[nodiscard]] bool is_known_encoding(std::string_view encoding);

/// Throws Error{kInput} naming `file` and `where` with the list of supported encodings: colours of 8 and 16
/// bits, Bayer mosaics (missing colours are means of neighbours), YUV (BT.601).
[[nodiscard]] Image picture_of(const ImageMessage& message,
                               const std::string& file,
                               const std::string& where);

}  // namespace simuli::ros2
