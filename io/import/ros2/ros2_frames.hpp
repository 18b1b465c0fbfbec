#pragma once
// Clouds and pictures of a recording as sweeps and pictures of a log. For io/import/ros2/*.cpp alone.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "host/core/base/image.hpp"
#include "io/bag/bag.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_lidar.hpp"
#include "io/import/ros2/ros2_log.hpp"

namespace simuli::ros2 {

struct RecordedCamera {
  std::string name;
  double readout_s = 0.0;
};

class FrameWriter {
 public:
  /// Frames that begin before `span` (nanoseconds since 1970) or end behind it are left out. Makes images/
  /// and sweeps/ in the folder.
  FrameWriter(const Bag& bag,
              const std::string& file,
              Log& log,
              const std::filesystem::path& folder,
              std::pair<std::int64_t, std::int64_t> span,
              Ros2Report& report);

  /// In one pass, by topic; adds the frames to the log. Errors as import_ros2().
  void write(const std::map<std::string, RecordedLidar>& lidars,
             const std::map<std::string, RecordedCamera>& cameras,
             const CloudFieldOptions& fields,
             const std::function<void(std::size_t, std::size_t)>& progress);

  /// How many frames there are.
  std::size_t total = 0;

 private:
  [[nodiscard]] bool is_on_path(double start_s, double end_s);
  [[nodiscard]] double seconds(std::int64_t stamp_ns) const;
  void add_cloud(const BagChannel& channel,
                 std::string_view data,
                 const RecordedLidar& lidar,
                 const CloudFieldOptions& options);
  void add_picture(const BagChannel& channel, std::string_view data, const RecordedCamera& camera);

  const Bag& bag_;
  const std::string& file_;
  Log& log_;
  std::filesystem::path folder_;
  std::pair<std::int64_t, std::int64_t> span_;
  Ros2Report& report_;
};

/// Error{kInput} naming `file` and `where` for another encoding than the line lists then: colours of 8 and 16
/// bits, Bayer's mosaics (each pixel lacks two colours: means of those beside it), YUV (BT.601).
[[nodiscard]] Image picture_of(const ImageMessage& message,
                               const std::string& file,
                               const std::string& where);

}  // namespace simuli::ros2
