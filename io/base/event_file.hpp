#pragma once
// Curves for TensorBoard: an event file (records of protobuf messages, each with its checksums).
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace simuli {

/// CRC-32C (Castagnoli) of `bytes`, as TFRecord files mask it: rotated right by 15 and offset.
[[nodiscard]] std::uint32_t masked_crc32c(const std::string& bytes);

/// Writes scalars as they come; every record is complete on disk once scalar() returns.
class EventFile {
 public:
  /// Makes `folder` when it is not there, and a file events.out.tfevents.<start>.simuli in it.
  /// `start_s`: seconds since 1970. Error{kInput} when that can't be done.
  EventFile(const std::filesystem::path& folder, double start_s);

  /// One point of curve `tag`. Error{kInput} when it can't be written.
  void scalar(const std::string& tag, std::int64_t step, double value, double time_s);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  void record(const std::string& message);
  std::filesystem::path file_;
  std::ofstream stream_;
};

}  // namespace simuli
