// support.h - data against which a frame's rays are compared to compute support. Structs as in reals.h; lengths
// in m, 3x3 matrices row-major.
#ifndef SIMULI_CL_SHARED_SUPPORT_H
#define SIMULI_CL_SHARED_SUPPORT_H

#include "reals.h"

#ifdef __cplusplus
namespace simuli::shared {
#endif

// Neighbouring rays of a block that share one lookup.
#define SIM_SUPPORT_RUN 4

SIM_REALS(SupportPose) {
  real rotation[9];
  real translation[3];
}
SIM_REALS_END(SupportPose);

SIM_REALS(SupportFrame) {
  SIM_REALS_OF(SupportPose) start, end;  // scene from sensor
  // Coefficients of the log odds: bias, angle and scale; for LiDARs doubt whether a ray returns, its drop
  // probability, and the difference between median and mean distance.
  real bias, angle, scale, doubt, drop, apart;
}
SIM_REALS_END(SupportFrame);

// The grid of cells around a recorded view.
SIM_REALS(SupportGrid) {
  real first_column, columns_per_unit;
  real first_row, rows_per_unit;
  real columns, rows;
  real first_cell;
  real fineness;  // its rays per radian relative to the current sensor
}
SIM_REALS_END(SupportGrid);

SIM_REALS(SupportBox) {
  SIM_REALS_OF(SupportPose) actor_from_scene;
  real half_size[3];
}
SIM_REALS_END(SupportBox);

// A recorded view, from the axes of the scene or of an actor.
SIM_REALS(SupportView) {
  real rotation[9];  // to the view's axes
  real position[3];  // of the view
  real there;        // 1; 0 if the recorded frame shows another state of the actor
  real enlargement;  // ratio of lengths then and now
}
SIM_REALS_END(SupportView);

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
