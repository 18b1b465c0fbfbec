#pragma once
// Frames of the Waymo Open Dataset with the field numbers of its published schema (dataset.proto, label.proto),
// for io/import/waymo/waymo.cpp and tests.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/log/log.hpp"

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
