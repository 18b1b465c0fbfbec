#pragma once
// Support: how well recorded frames support a rendered frame.
#include <memory>
#include <string>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/record/support_record.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Computes the support of every ray of a frame in [0, 1] from the frames that the scene was trained on:
/// whether they saw its point, the smallest viewing angle between both rays, the relative sampling, the scene's
/// error and contrast in the recorded frames there; for LiDARs also the certainty that the ray returns or not,
/// and from one distance. A pixel's support is the share of such pixels whose colour is within kSupportColour
/// of the truth (mean of the channels); a LiDAR ray's the share of such rays that return within kSupportRange_m
/// of the truth or rightly do not return, calibrated on the demo's street off its path, for pixels also on
/// held-out frames of drives (docs/METHOD.md section 16). 0 where no recorded frame saw the point. The frame
/// keeps its bits. Of four neighbours (pixels of a row, firings of a beam) one is looked up, in fine pictures
/// of up to 4 x 4 pixels, at most a quarter of a recorded cell; whether a LiDAR ray returns is evaluated for
/// each ray.
class SupportOnDevice {
 public:
  /// Throws Error{kUsage} without a record, for instance of a scene trained by an older version or not at all.
  SupportOnDevice(const Device& device, std::shared_ptr<const SupportRecord> record);
  ~SupportOnDevice();
  SupportOnDevice(SupportOnDevice&&) noexcept;
  SupportOnDevice& operator=(SupportOnDevice&&) noexcept;

  /// Returns the support by ray, in the sensor's order; 0 for pixels without a ray. `scene`: the rendered one;
  /// its actors are found in the record by name, those in `copies` by their originals' name; others count as
  /// never seen. Waits.
  [[nodiscard]] std::vector<float> of(const Frame& frame, const Scene& scene, const ActorCopies& copies = {});
  /// Returns the support of a camera's frame as a picture: [height][width][1].
  [[nodiscard]] Image image_of(const Frame& frame, const Scene& scene, const ActorCopies& copies = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline constexpr double kSupportColour = 0.05;
inline constexpr double kSupportRange_m = 0.02;

/// Largest number of recorded views compared with one frame.
inline constexpr std::size_t kMostSupportViews = 8;
/// Selects the record's views of that kind: for cameras the nearest to the sensor, where a view to its side
/// counts as 10 m farther and a view backwards as 20 m; for LiDARs half as many nearest ones, and as many
/// others evenly by distance. world_from_view: in the grid's axes.
[[nodiscard]] std::vector<std::size_t> support_views_around(const SupportRecord& record,
                                                            SetKind kind,
                                                            const Pose& world_from_view);

/// Coefficients of the log odds: a constant plus these times a / (a + 0.1) with a the smallest angle (chord) to
/// a ray that saw the point, the finest sampling relative to this ray (at most 1), mean ln of error and
/// contrast, the depth of the cells relative to the distance, and for a LiDAR ray 4 p (1 - p) and p, its
/// ray-drop probability, and x / (x + 1 cm), with x the difference of mean and median distance.
struct SupportTrust {
  double constant, angle, scale, error, contrast, edge, doubt, drop, apart;
};
[[nodiscard]] const SupportTrust& support_trust(SetKind kind);

}  // namespace simuli
