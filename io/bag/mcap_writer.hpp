#pragma once
// Writer of MCAP files (https://mcap.dev/spec): messages in compressed chunks with checksums, indexes and a
// summary.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace simuli {

/// Writes a file sequentially; it is complete after finish(). The caller passes a temporary name
/// (io/base/file.hpp). Throws Error{kInput} naming the file if it cannot be written.
class McapWriter {
 public:
  enum class Compression { kNone, kZstd };
  struct Channel {
    std::string topic;
    std::string schema;    // name: "sensor_msgs/msg/Image"
    std::string encoding;  // of the schema: "ros2msg"
    std::string definition;
    std::string message_encoding;  // "cdr"
    std::map<std::string, std::string> metadata = {};
  };

  /// Throws Error{kUsage} for a compression that this build does not support. The message that fills a chunk
  /// closes it.
  McapWriter(std::filesystem::path file,
             const std::string& profile,
             Compression compression,
             std::size_t chunk_bytes = std::size_t{1} << 22U);

  /// Returns the channel's id for add_message(); equal schemas are written once.
  std::uint16_t add_channel(const Channel& channel);
  /// The publish time equals the log time. Throws Error{kInternal} for an unknown channel.
  void add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
  /// Writes the last chunk, the summary and the footer.
  void finish();

 private:
  using Times = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // log time, offset in the chunk
  struct ChunkIndex {
    std::uint64_t first_ns, last_ns, start, length, index_length, compressed, size;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };

  void write(std::string_view bytes);
  void close_chunk();
  [[nodiscard]] std::string statistics() const;

  std::filesystem::path file_;
  std::ofstream out_;
  Compression compression_;
  std::size_t chunk_bytes_;
  std::uint64_t written_ = 0;
  std::uint32_t crc_ = 0;
  std::string schemas_, channels_;  // records, repeated in the summary
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::uint64_t> counts_;  // messages by channel
  std::vector<ChunkIndex> chunks_;
  std::string chunk_;
  std::map<std::uint16_t, Times> chunk_times_;
};

}  // namespace simuli
