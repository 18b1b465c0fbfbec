#pragma once
// MCAP files (https://mcap.dev/spec): messages in compressed chunks, with checksums, indexes and a summary.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace simuli {

/// Writes a file from start to end: whole once finish() has returned. Whoever calls gives a temporary name
/// (io/base/file.hpp). Error{kInput} naming the file when it can't be written.
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

  /// Error{kUsage} for a compression that this build lacks. A chunk is closed by the message that fills it.
  McapWriter(std::filesystem::path file,
             const std::string& profile,
             Compression compression,
             std::size_t chunk_bytes = std::size_t{1} << 22U);

  /// The number by which messages name it; equal schemas are written once.
  std::uint16_t add_channel(const Channel& channel);
  /// Published when it is logged. Error{kInternal} for a channel that was not added.
  void add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
  /// Writes what is left, the summary and the footer.
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
  std::string schemas_, channels_;  // records, once more in the summary
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::uint64_t> counts_;  // by channel
  std::vector<ChunkIndex> chunks_;
  std::string chunk_;
  std::map<std::uint16_t, Times> chunk_times_;
};

}  // namespace simuli
