#pragma once
// Frames of the Waymo Open Dataset with the field numbers of its published schema (dataset.proto, label.proto),
// for io/import/waymo/waymo.cpp and tests.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// Reads records: length, checksum, bytes, checksum. Does not verify checksums: a damaged message does not
/// match its schema.
class TfRecords {
 public:
  /// Throws Error{kInput} for an empty or unreadable file.
  explicit TfRecords(const std::filesystem::path& file);
  /// Returns false at the end. Throws Error{kInput} for a truncated record.
  [[nodiscard]] bool next(std::string& record);
  /// Size of the file and number of bytes read.
  [[nodiscard]] std::uintmax_t size() const { return bytes_; }
  [[nodiscard]] std::uintmax_t at() const { return at_; }

 private:
  std::string file_;
  std::ifstream in_;
  std::uintmax_t bytes_ = 0, at_ = 0;
};

}  // namespace simuli

namespace simuli::waymo {

/// A sensor's data in a frame, with times in seconds since 1970, which a double represents to a quarter of a
/// microsecond.
struct Picture {
  std::uint64_t name = 0;
  std::string_view bytes;
  double start_s = 0.0, end_s = 0.0;
};
struct Box {
  std::string id;
  std::uint64_t type = 0;
  std::array<double, 8> values{};  // by field: center 1 to 3, width, length, height, heading
};
struct Frame {
  std::string name;
  std::vector<std::string_view> cameras, lidars;  // calibrations
  double time_s = 0.0;
  Pose world_from_vehicle;
  std::vector<Picture> pictures;
  std::vector<std::pair<double, Pose>> poses;  // of the pictures
  std::string_view top;                        // compressed range image
  std::vector<Box> boxes;
};

/// The range image: [rows][columns][channels]; the first two channels are range and intensity.
struct Grid {
  std::size_t rows = 0, columns = 0, channels = 0;
  std::vector<float> values;
};

/// Reads the messages of one segment, whose name appears in errors: throws Error{kInput} naming file and
/// message for data that does not match the schema. Results refer to the given bytes.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[nodiscard]] Frame frame(std::string_view bytes) const;
  [[nodiscard]] LogCamera camera(std::string_view calibration) const;
  /// Returns the LiDAR TOP for a range image of that size; false for another LiDAR.
  [[nodiscard]] bool lidar(std::string_view calibration,
                           std::size_t rows,
                           std::size_t columns,
                           LogLidar& out) const;
  [[nodiscard]] Grid grid(std::string_view compressed) const;
  [[nodiscard]] std::string camera_name(std::uint64_t name) const;

 private:
  [[nodiscard]] Pose transform(std::string_view bytes) const;
  void context(std::string_view bytes, Frame& f) const;
  void picture(std::string_view bytes, Frame& f) const;
  void laser(std::string_view bytes, Frame& f) const;
  [[nodiscard]] Box box(std::string_view bytes) const;

  std::string file_;
};

/// Returns the first returns of a range image with the sensor's size.
[[nodiscard]] Sweep sweep_of(const Grid& grid, const Lidar& lidar);

}  // namespace simuli::waymo

namespace simuli {

struct WireField {
  std::uint32_t number = 0;
  std::uint64_t value = 0;  // of a varint, or the bits of a fixed32 or fixed64
  std::string_view bytes;   // of a string, message or packed array; also of fixed values
  bool is_bytes = false;
};

/// Returns all fields of a message in order. Throws Error{kInput} "FILE: WHAT: ..." if they do not end at its
/// end.
[[nodiscard]] std::vector<WireField> wire_fields(std::string_view message,
                                                 const std::string& file,
                                                 const char* what);

/// Appends the doubles of a field, packed or single.
void append_doubles(const WireField& field, std::vector<double>& to);
[[nodiscard]] double wire_double(const WireField& field);
/// Returns a packed array of floats.
[[nodiscard]] std::vector<float> wire_floats(std::string_view bytes);

}  // namespace simuli
