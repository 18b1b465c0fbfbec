#pragma once
// What a training is told that decides itself how long it goes on, and what it says of that.
#include "host/core/base/allowed.hpp"

namespace simuli {

/// Stages, each of which is a training with its rates run down: the first as long as its frames ask for, each
/// further one longer by `growth`. What a stage has gained over the one before decides whether another
/// follows.
struct LengthOptions {
  bool automatic = false;
  double first_epochs = 10.0;  // looks at each training picture in the first stage
  double growth = 1.5;         // iterations at the end of a stage over those of the one before
  // What asks for another stage, per doubling of the iterations: dB of training pictures, or the share by which
  // the LiDAR set's loss falls.
  double gain_db = 0.5;
  double gain_share = 0.05;
  int most = 6000;  // iterations, however much is gained
};
template <class F>
constexpr void visit_fields(LengthOptions& o, F&& field) {
  field.group("Length");
  field("auto.on",
        o.automatic,
        "Train until training frames gain little, whatever iterations says (--iterations auto). true: for a "
        "drive of unknown difficulty.");
  field.internal(o.first_epochs);
  field.internal(o.growth);
  field.internal(o.gain_db);
  field.internal(o.gain_share);
  field.internal(o.most);
}

/// The end of a stage. Gains are those per doubling of the iterations; NaN where a set has no frames, and in
/// the first stage.
struct LengthStage {
  int iterations = 0;
  double square = 0.0;      // of training pictures' colours, a mean over all of them
  double lidar_loss = 0.0;  // weighted, a mean over all training sweeps
  double gain_db = 0.0;
  double gain_share = 0.0;
};

}  // namespace simuli
