#pragma once
// Recorded messages by topic from MCAP files, rosbag2's SQLite databases, and folders of several such files as
// written by `ros2 bag record`.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace simuli {

/// Origin of a message. All messages of a channel share one object.
struct BagChannel {
  std::string topic;
  std::string type;      // "sensor_msgs/msg/Image"
  std::string encoding;  // of its messages: "cdr"
};

class Bag {
 public:
  /// `data` is valid during the call only.
  using OnMessage =
      std::function<void(const BagChannel& channel, std::uint64_t log_ns, std::string_view data)>;
  using Wanted = std::function<bool(const BagChannel& channel)>;

  virtual ~Bag() = default;
  /// Calls `on_message` for all wanted messages in file order, with one chunk in memory at a time. Throws
  /// Error{kInput} naming file and field for damaged and truncated files, when it reaches the damage.
  virtual void read(const Wanted& wanted, const OnMessage& on_message) const = 0;
};

/// Limit of messages and decompressed chunks, because a few bytes can claim any size.
inline constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 28U;

/// Opens a .mcap or .db3 file, or a folder of them. Throws Error{kInput} for other files and for a container
/// that this build does not support.
[[nodiscard]] std::unique_ptr<const Bag> open_bag(const std::filesystem::path& path);

[[nodiscard]] std::unique_ptr<const Bag> open_mcap(const std::filesystem::path& file);
[[nodiscard]] std::unique_ptr<const Bag> open_sqlite_bag(const std::filesystem::path& file);

}  // namespace simuli
