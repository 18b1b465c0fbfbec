// support.h - what a frame's rays are compared with to tell how well they are known. Structs as in reals.h; lengths in m,
// 3x3 matrices row-major.
#ifndef SIMULI_CL_SHARED_SUPPORT_H
#define SIMULI_CL_SHARED_SUPPORT_H

#include "reals.h"

#ifdef __cplusplus
namespace simuli::shared {
#endif

// Neighbours along a slot row that are looked up alike.
#define SIM_SUPPORT_RUN 4

SIM_REALS(SupportPose) {
  real rotation[9];
  real translation[3];
}
SIM_REALS_END(SupportPose);

SIM_REALS(SupportFrame) {
  SIM_REALS_OF(SupportPose) start, end;  // scene from sensor
  // Of the logarithm of odds: a bias, by angle and scale; of LiDARs by doubt whether a ray returns, its drop
  // probability, and how far median and mean distance are apart.
  real bias, angle, scale, doubt, drop, apart;
}
SIM_REALS_END(SupportFrame);

// The grid of cells around a recorded view.
SIM_REALS(SupportGrid) {
  real first_column, columns_per_unit;
  real first_row, rows_per_unit;
  real columns, rows;
  real first_cell;
  real fineness;  // its rays per radian over those of the sensor now
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
  real position[3];  // where it stood
  real there;        // 1, or 0: it has seen another state of the world
  real enlargement;  // how many times larger lengths were then
}
SIM_REALS_END(SupportView);

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
