#pragma once
// The choice of a log's frames for training and their image scale. Initialisation, training and, by default, evaluation
// share it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "host/core/base/allowed.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct FrameSelection {
  double image_scale = 0.5;
  int held_out_every = 5;
  double held_out_middle = 0.0;
  double held_out_last = 0.0;
  std::vector<std::string> held_out_sensors = {};  // cameras and LiDARs whose frames are all held out
  std::uint64_t seed = 1;                          // of the order of the frames and of the thinning of points
  /// Whether frames are counted per sensor. False only for older scenes, which counted all cameras' pictures together.
  bool counts_by_sensor = true;
};

/// Visits the settings with their allowed values and descriptions (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(FrameSelection& o, F&& field) {
  field.group("Data");
  field("image_scale",
        o.image_scale,
        above(0.0, 1.0),
        "Size of the training pictures relative to the recorded ones. 1: sharpest, four times the pixels "
        "of 0.5.");
  field("held_out_every",
        o.held_out_every,
        zero_or(at_least(2)),
        "Hold out every N-th frame of each camera and LiDAR for evaluation; 0: train on all frames.");
  field("held_out_middle",
        o.held_out_middle,
        range(0.0, 0.9),
        "Also hold out the frames on this share of the trajectory, around its middle.");
  field("held_out_last",
        o.held_out_last,
        range(0.0, 0.9),
        "Also hold out the frames on this share of the trajectory, at its end.");
  field("held_out_sensors",
        o.held_out_sensors,
        "Cameras and LiDARs, with commas between, of which all frames are kept for evaluation.");
  field("seed",
        o.seed,
        at_least(0),
        "Seed of the frames' order and of thinning. Another seed shows how much results scatter.");
  field.internal(o.counts_by_sensor);
}

/// Describes the held-out frames, as in "every 5. frame, the last 20 % of the path"; empty if there are none.
[[nodiscard]] std::string held_out_text(const FrameSelection& frames);

/// Returns the selection with no frame held out.
[[nodiscard]] FrameSelection nothing_held_out(FrameSelection frames);

/// The use of a frame: for training, or the reason why it is held out.
enum class FrameUse {
  kTraining,
  kBetween,  // held out between training frames: interpolation
  kMiddle,   // held out in a part of the path that has training frames only before and after it
  kBeyond,   // held out at the end of the path, after all training frames: extrapolation
  kSensor,   // held out because all frames of its camera or LiDAR are
};

/// Decides which frames of a log are held out. A frame is held out if one of these rules applies, the first of which
/// determines its FrameUse:
/// - held_out_sensors: all frames of these cameras and LiDARs (kSensor).
/// - held_out_last: frames that end within the last share of the path by length (kBeyond).
/// - held_out_middle: frames that overlap this share of the path around its middle (kMiddle).
/// - held_out_every = N: the last of every N moments of the rig (rig_moments.hpp), that is every N-th frame of each
///   camera and LiDAR, where frames of one moment are held out together (kBetween).
class HeldOutRule {
 public:
  /// Error{kInput} for a share of a path that is 0 m long, Error{kUsage} for a sensor that the log lacks.
  HeldOutRule(const Log& log, const FrameSelection& frames);

  /// Returns the use of the frame at `index` among the log's pictures or its sweeps.
  template <class Frame>
  [[nodiscard]] FrameUse use(std::size_t index, const Frame& frame) const {
    if (sensors_.contains(sensor_of(frame))) return FrameUse::kSensor;
    if (frame.time_end_s > cut_s_) return FrameUse::kBeyond;
    if (frame.time_end_s > middle_s_[0] && frame.time_start_s < middle_s_[1]) return FrameUse::kMiddle;
    if (every_ == 0) return FrameUse::kTraining;
    const std::size_t moment = counts_by_sensor_ ? moments_of(frame)[index] : index;
    return moment % every_ == every_ - 1 ? FrameUse::kBetween : FrameUse::kTraining;
  }
  /// Indices of the training frames and of the held-out frames.
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> training(const std::vector<Frame>& frames) const {
    return select(frames, true);
  }
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> held_out(const std::vector<Frame>& frames) const {
    return select(frames, false);
  }

 private:
  template <class Frame>
  [[nodiscard]] std::vector<std::size_t> select(const std::vector<Frame>& frames, bool trained) const {
    std::vector<std::size_t> selected;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if ((use(i, frames[i]) == FrameUse::kTraining) == trained) selected.push_back(i);
    }
    return selected;
  }

  [[nodiscard]] static const std::string& sensor_of(const ImageFrame& frame) { return frame.camera; }
  [[nodiscard]] static const std::string& sensor_of(const SweepFrame& frame) { return frame.lidar; }
  [[nodiscard]] const std::vector<std::size_t>& moments_of(const ImageFrame& /*any*/) const {
    return images_;
  }
  [[nodiscard]] const std::vector<std::size_t>& moments_of(const SweepFrame& /*any*/) const {
    return sweeps_;
  }

  std::size_t every_;
  bool counts_by_sensor_;
  std::vector<std::size_t> images_, sweeps_;  // number of the moment of each frame
  std::set<std::string> sensors_;             // held out
  double cut_s_ = std::numeric_limits<double>::infinity();
  std::array<double, 2> middle_s_{cut_s_, cut_s_};  // start and end
};

/// Numbers of training and held-out frames of one camera or LiDAR.
struct SensorUse {
  std::string sensor;
  std::size_t training = 0, held_out = 0;  // frames
};
/// Returns the numbers for each of the log's cameras, then for its LiDARs.
[[nodiscard]] std::vector<SensorUse> sensor_uses(const Log& log, const HeldOutRule& rule);

/// Returns the names of the log's cameras and LiDARs that are not in `sensors`. Error{kUsage} naming `key` for a sensor
/// that the log lacks.
[[nodiscard]] std::vector<std::string> other_sensors(const Log& log,
                                                     const std::vector<std::string>& sensors,
                                                     const std::string& key);

}  // namespace simuli
