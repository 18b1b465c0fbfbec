#pragma once
// Recorded messages by topic, from whatever container they are in: MCAP, rosbag2's SQLite database, or a
// folder of several of one kind as `ros2 bag record` splits them.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace simuli {

/// Where a message is from. One channel's messages come with the same object.
struct BagChannel {
  std::string topic;
  std::string type;      // "sensor_msgs/msg/Image"
  std::string encoding;  // of its messages: "cdr"
};

class Bag {
 public:
  /// `data` lives as long as the call.
  using OnMessage =
      std::function<void(const BagChannel& channel, std::uint64_t log_ns, std::string_view data)>;
  using Wanted = std::function<bool(const BagChannel& channel)>;

  virtual ~Bag() = default;
  /// All messages that are wanted, in the order in which they stand in the file, of which a part at a time is
  /// in memory. Error{kInput} naming file and field for damaged and truncated files, once that part is
  /// reached.
  virtual void read(const Wanted& wanted, const OnMessage& on_message) const = 0;
};

/// Messages and chunks of more bytes are refused: a few bytes may say to become as many.
inline constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 28U;

/// A .mcap or .db3 file, or a folder of such. Error{kInput} when it is neither, and for a kind that this
/// build lacks.
[[nodiscard]] std::unique_ptr<const Bag> open_bag(const std::filesystem::path& path);

[[nodiscard]] std::unique_ptr<const Bag> open_mcap(const std::filesystem::path& file);
[[nodiscard]] std::unique_ptr<const Bag> open_sqlite_bag(const std::filesystem::path& file);

}  // namespace simuli
