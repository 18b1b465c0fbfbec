#pragma once
// Options and results of trainings of automatic length.
#include "host/core/base/allowed.hpp"

namespace simuli {

/// An automatic training has stages, each with a full decay of the learning rates; each stage is longer than
/// the previous one by the factor `growth`. The gain of a stage over the previous one decides whether another
/// follows.
struct LengthOptions {
  bool automatic = false;
  double first_epochs = 10.0;  // uses of each training picture in the first stage
  double growth = 1.5;         // ratio of the iterations at the ends of consecutive stages
  // Gains per doubling of the iterations that start another stage: dB of training pictures, or the relative
  // decrease of the LiDAR set's loss.
  double gain_db = 0.5;
  double gain_share = 0.05;
  int most = 6000;  // maximum number of iterations
};
template <class F>
constexpr void visit_fields(LengthOptions& o, F&& field) {
  field.group("Length");
  field("auto.on",
        o.automatic,
        "Train until the scores of training frames converge, independent of iterations (--iterations "
        "auto). true: for a drive of unknown difficulty.");
  field.internal(o.first_epochs);
  field.internal(o.growth);
  field.internal(o.gain_db);
  field.internal(o.gain_share);
  field.internal(o.most);
}

/// The end of a stage. Gains are per doubling of the iterations; NaN in the first stage and for sets without
/// frames.
struct LengthStage {
  int iterations = 0;
  double square = 0.0;      // mean squared colour error of training pictures
  double lidar_loss = 0.0;  // weighted LiDAR loss, mean over training sweeps
  double gain_db = 0.0;
  double gain_share = 0.0;
};

}  // namespace simuli
