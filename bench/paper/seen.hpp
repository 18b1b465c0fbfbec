#pragma once
// Classifies pixels by their visibility in the training pictures. Content that no training picture shows can
// only be invented.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/base/image.hpp"
#include "io/synth/street.hpp"

namespace simuli::bench {

enum class Seen : std::uint8_t {
  kNever,     // occluded or outside the picture in each training picture
  kCoarsely,  // visible, but with less than kLeastShare of this picture's pixels per area
  kWell
};

/// Training pictures of a log of the street.
class SeenBefore {
 public:
  static constexpr double kLeastShare = 0.25;  // half as many along each side

  /// All pictures of `log` are training pictures. `street` must outlive this object; `car` is its moving car.
  SeenBefore(const TracedWorld& street, const std::optional<StreetCar>& car, const Log& log);

  /// Returns the class of each pixel centre, [height][width], at the middle of the exposure from time_start_s
  /// to time_end_s. The car is compared at its position at the time of each picture; the sky is visible if a
  /// picture shows it in the same direction.
  [[nodiscard]] std::vector<Seen> of(const LogCamera& camera,
                                     const Trajectory& world_from_rig,
                                     double time_start_s,
                                     double time_end_s) const;

 private:
  struct Picture {
    Camera camera;
    Pose world_from_camera;
    double time_s = 0.0;
  };
  /// A surface or the sky at a pixel that covers area_m2 of it.
  struct Surface {
    StreetHit hit;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  // world, m; for the sky its direction
    double time_s = 0.0;
    double area_m2 = 0.0;
  };
  [[nodiscard]] static Surface place(const TracedWorld& street,
                                     const Picture& picture,
                                     const Eigen::Vector2d& pixel);
  /// Returns the ratio of the picture's pixels per area to this picture's; no value if not visible.
  [[nodiscard]] std::optional<double> share(const Picture& picture, const Surface& place) const;

  const TracedWorld& street_;
  std::optional<StreetCar> car_;
  std::vector<Picture> pictures_;
};

/// Picture errors by class of visibility.
class SeenErrors {
 public:
  /// Adds a picture with its classes `seen` [height][width].
  void add(const Image& rendered, const Image& truth, const std::vector<Seen>& seen);

  /// Returns the share of this class of all pixels.
  [[nodiscard]] double share(Seen seen) const;
  /// Returns the PSNR of this class over all pictures in dB; infinite without pixels.
  [[nodiscard]] double psnr_db(Seen seen) const;
  /// Returns the mean PSNR over the pictures in dB if visible pixels had the error of `path`, the same
  /// pictures from the recorded trajectory, and the others their own: an upper bound for methods that invent
  /// no content.
  [[nodiscard]] double psnr_of_seen_as_in_db(const SeenErrors& path) const;

 private:
  struct Sum {
    std::size_t pixels = 0;
    double squares = 0.0;  // squared errors, mean of the channels
  };
  using Picture = std::array<Sum, 3>;  // [Seen]
  [[nodiscard]] Sum sum(Seen seen) const;
  std::vector<Picture> pictures_;
};

}  // namespace simuli::bench
