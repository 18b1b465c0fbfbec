#pragma once
// Which frames of a log a scene is made from, and at which size: the same for its start, its training and,
// unless asked otherwise, its evaluation.
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
  std::vector<std::string> held_out_sensors = {};  // cameras and LiDARs of which all frames are held out
  std::uint64_t seed = 1;  // of the frames' order, and of which points go when there are too many
  bool counts_by_sensor =
      true;  // false: as versions did of which a scene does not say it (training_json.hpp)
};

/// The keys that users set, with what is allowed and what it means (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(FrameSelection& o, F&& field) {
  field.group("Data");
  field("image_scale",
        o.image_scale,
        above(0.0, 1.0),
        "Size of the training pictures over the recorded ones. 1: sharpest, four times the pixels of 0.5.");
  field("held_out_every",
        o.held_out_every,
        zero_or(at_least(2)),
        "Keep every N-th frame of each camera and LiDAR for evaluation; 0: train on all frames.");
  field("held_out_middle",
        o.held_out_middle,
        range(0.0, 0.9),
        "Keep the frames on this share of the path, around its middle, for evaluation as well.");
  field("held_out_last",
        o.held_out_last,
        range(0.0, 0.9),
        "Keep the frames on this share of the path, at its end, for evaluation as well.");
  field("held_out_sensors",
        o.held_out_sensors,
        "Cameras and LiDARs, with commas between, of which all frames are kept for evaluation.");
  field("seed",
        o.seed,
        at_least(0),
        "Seed of the frames' order and of thinning. Another seed shows how much results scatter.");
  field.internal(o.counts_by_sensor);
}

/// "every 5. frame, the last 20 % of the path": what is held out; empty: nothing.
[[nodiscard]] std::string held_out_text(const FrameSelection& frames);

/// The same selection, but that every frame is trained on.
[[nodiscard]] FrameSelection nothing_held_out(FrameSelection frames);

/// What a frame is to a training.
enum class FrameUse {
  kTraining,
  kBetween,  // held out, training frames before and behind: what a scene makes of what it saw
  kMiddle,   // held out in a chunk of the path that training saw from either end alone
  kBeyond,   // held out at the end of the path, where training read nothing: what it makes of the rest
  kSensor,   // of a camera or LiDAR that is held out whole
};

/// The one rule by which frames of a log are held out. Whole sensors, with held_out_sensors. With
/// held_out_every = N the last of every N moments of the rig (rig_moments.hpp): every N-th frame of each camera
/// and LiDAR, those of one moment together. With held_out_last the frames that end when the rig has that share
/// of its path, by length, still before it, or later; with held_out_middle those during which it is in the part
/// of that share around the path's middle. Together they hold out what any does; a frame of a sensor that is held
/// out is kSensor, one behind the cut kBeyond and one in the middle kMiddle whatever its moment.
class HeldOutRule {
 public:
  /// Error{kInput} when a share of a path is asked for that is 0 m long, Error{kUsage} for a sensor that the
  /// log does not have.
  HeldOutRule(const Log& log, const FrameSelection& frames);

  /// Of the frame at `index` among the log's pictures or its sweeps.
  template <class Frame>
  [[nodiscard]] FrameUse use(std::size_t index, const Frame& frame) const {
    if (sensors_.contains(sensor_of(frame))) return FrameUse::kSensor;
    if (frame.time_end_s > cut_s_) return FrameUse::kBeyond;
    if (frame.time_end_s > middle_s_[0] && frame.time_start_s < middle_s_[1]) return FrameUse::kMiddle;
    if (every_ == 0) return FrameUse::kTraining;
    const std::size_t moment = counts_by_sensor_ ? moments_of(frame)[index] : index;
    return moment % every_ == every_ - 1 ? FrameUse::kBetween : FrameUse::kTraining;
  }
  /// Indices of the frames that training reads, and of all others.
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
  std::vector<std::size_t> images_, sweeps_;  // of which moment they are
  std::set<std::string> sensors_;             // held out
  double cut_s_ = std::numeric_limits<double>::infinity();
  std::array<double, 2> middle_s_{cut_s_, cut_s_};  // from, until
};

/// What becomes of the frames of one camera or LiDAR.
struct SensorUse {
  std::string sensor;
  std::size_t training = 0, held_out = 0;  // frames
};
/// Of each of the log's cameras, then its LiDARs.
[[nodiscard]] std::vector<SensorUse> sensor_uses(const Log& log, const HeldOutRule& rule);

/// The names of a log's cameras and LiDARs but these. Error{kUsage} naming `key` for one that the log doesn't have.
[[nodiscard]] std::vector<std::string> other_sensors(const Log& log,
                                                     const std::vector<std::string>& sensors,
                                                     const std::string& key);

}  // namespace simuli
