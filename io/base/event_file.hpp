#pragma once
// TensorBoard event files: protobuf messages as records with checksums.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace simuli {

/// Returns the CRC-32C (Castagnoli) of `bytes`, masked as in TFRecord files: rotated right by 15 and offset.
[[nodiscard]] std::uint32_t masked_crc32c(const std::string& bytes);

/// Writes scalars; each record is complete on disk when scalar() returns.
class EventFile {
 public:
  /// Creates `folder` if it is missing, and a file events.out.tfevents.<start>.simuli in it. `start_s`: seconds
  /// since 1970. Throws Error{kInput} on failure.
  EventFile(const std::filesystem::path& folder, double start_s);

  /// Appends a point of the curve `tag`. Throws Error{kInput} if it cannot be written.
  void scalar(const std::string& tag, std::int64_t step, double value, double time_s);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  void record(const std::string& message);
  std::filesystem::path file_;
  std::ofstream stream_;
};

}  // namespace simuli
