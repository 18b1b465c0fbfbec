#pragma once
// Which pixels show what the training pictures show as well. What none of them has seen, no method knows that
// invents nothing.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/core/base/image.hpp"
#include "io/synth/street.hpp"

namespace simuli::bench {

enum class Seen : std::uint8_t {
  kNever,     // each training picture has something before it, or ends before it
  kCoarsely,  // in pictures, of which none spends kLeastShare of the pixels on it that are spent here
  kWell
};

/// The training pictures of a log of the street.
class SeenBefore {
 public:
  static constexpr double kLeastShare = 0.25;  // half as many along each side

  /// All pictures of `log` teach. `street` must outlive it; `car` as it drives on it.
  SeenBefore(const TracedWorld& street, const std::optional<StreetCar>& car, const Log& log);

  /// What the middle of each pixel shows, [height][width], half-way through the exposure from time_start_s to
  /// time_end_s. What drives is seen where the car is then; the sky where a picture shows it that way.
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
  /// A surface, or the sky, as a pixel of area_m2 on it meets it.
  struct Surface {
    StreetHit hit;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  // world, m; of the sky the direction to it
    double time_s = 0.0;
    double area_m2 = 0.0;
  };
  [[nodiscard]] static Surface place(const TracedWorld& street,
                                     const Picture& picture,
                                     const Eigen::Vector2d& pixel);
  /// How many pixels the picture spends on it, of those that are spent there; none: it isn't seen.
  [[nodiscard]] std::optional<double> share(const Picture& picture, const Surface& place) const;

  const TracedWorld& street_;
  std::optional<StreetCar> car_;
  std::vector<Picture> pictures_;
};

/// Errors of pictures apart by what was seen before.
class SeenErrors {
 public:
  /// One picture. `seen` [height][width] of it.
  void add(const Image& rendered, const Image& truth, const std::vector<Seen>& seen);

  /// Of all pixels of all pictures.
  [[nodiscard]] double share(Seen seen) const;
  /// Of these pixels of all pictures together, dB; infinite without any.
  [[nodiscard]] double psnr_db(Seen seen) const;
  /// Mean over the pictures, dB, if whatever was seen before were off by as much as it is in `path`, which
  /// has the same pictures from the recorded path, and the rest as it is: what is left to those who invent
  /// nothing.
  [[nodiscard]] double psnr_of_seen_as_in_db(const SeenErrors& path) const;

 private:
  struct Sum {
    std::size_t pixels = 0;
    double squares = 0.0;  // of the error, mean of the channels
  };
  using Picture = std::array<Sum, 3>;  // [Seen]
  [[nodiscard]] Sum sum(Seen seen) const;
  std::vector<Picture> pictures_;
};

}  // namespace simuli::bench
