#pragma once
// How well what a frame shows is known.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/record/support_record.hpp"
#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Copies of actors, by name, and whose copies they are.
using ActorCopies = std::map<std::string, std::string>;

/// Tells of every ray of a frame, in [0, 1], how well what it shows is known from the frames that the scene
/// was made of: whether its point was seen in them, from how near in angle, how finely, how wrong the scene is
/// there in the recorded frames and how much goes on there; of a LiDAR also how sure it is that the ray
/// returns, or does not, and from one distance. A pixel's is the share of pixels alike whose colour is within
/// kSupportColour of the truth (mean of the channels), a LiDAR ray's that of rays which return within
/// kSupportRange_m of the truth, or rightly don't: as measured on the demo's street off its path, pixels' also
/// on what drives held out (docs/METHOD.md section 16). 0 where no recorded frame saw what is shown. The frame
/// stays as it is: its bits are the same with support and without. Of four neighbours (pixels of a row, firings
/// of a beam) one is looked up in recorded frames, of pictures finer than those of up to 4 x 4 pixels, at most
/// a quarter of one of the record's cells; whether a LiDAR's rays return is told of each by itself.
class SupportOnDevice {
 public:
  /// Error{kUsage} without a record: the scene was trained before there were any, or not at all.
  SupportOnDevice(const Device& device, std::shared_ptr<const SupportRecord> record);
  ~SupportOnDevice();
  SupportOnDevice(SupportOnDevice&&) noexcept;
  SupportOnDevice& operator=(SupportOnDevice&&) noexcept;

  /// By ray, in the sensor's order; 0 of pixels without a ray. `scene`: the one rendered; its actors are
  /// looked up in the record by name, those of `copies` by their originals', and others have never been seen.
  /// Waits.
  [[nodiscard]] std::vector<float> of(const Frame& frame, const Scene& scene, const ActorCopies& copies = {});
  /// The same of a camera's frame, as a picture: [height][width][1].
  [[nodiscard]] Image image_of(const Frame& frame, const Scene& scene, const ActorCopies& copies = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline constexpr double kSupportColour = 0.05;
inline constexpr double kSupportRange_m = 0.02;

/// Recorded views that one frame is compared with, at most.
inline constexpr std::size_t kMostSupportViews = 8;
/// Of the record's views of that kind, of cameras those nearest to a sensor, of which one that looks to its side counts
/// as 10 m farther and one that looks back as 20 m; of LiDARs half as many, and as many of the others, evenly spread
/// by distance. world_from_view: in the grid's axes.
[[nodiscard]] std::vector<std::size_t> support_views_around(const SupportRecord& record,
                                                            SetKind kind,
                                                            const Pose& world_from_view);

/// The logarithm of the odds is a constant plus these times a / (a + 0.1), a the least angle (its chord) to a
/// ray that saw the point, the finest look over this one (at most 1), mean ln of error and of contrast, the
/// depth of the cells over the distance, and of a LiDAR's ray 4 p (1 - p) and p, its drop probability, and
/// x / (x + 1 cm), x by how much the mean and the median of where its light comes from differ.
struct SupportTrust {
  double constant, angle, scale, error, contrast, edge, doubt, drop, apart;
};
[[nodiscard]] const SupportTrust& support_trust(SetKind kind);

}  // namespace simuli
