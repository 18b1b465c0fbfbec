// met.h - responses of rays in their own order, for the forward (light.h) and backward (light_bwd.h) pass, so
// that both round alike.
// Build: SIM_REPLAY = 1 (in kernels that replay) stores each response's position in the tile's list.
#ifndef SIMULI_CL_MATH_MET_H
#define SIMULI_CL_MATH_MET_H
#include "math/ray_feature.h"
#include "math/tile.h"

#ifndef SIM_REPLAY
#define SIM_REPLAY 0
#endif

/// Response of one particle for the V rays of a vector. A ray that misses it has alpha 0 and the tau of the
/// entry before, so that sorting leaves it in place.
typedef struct {
  F tau;  // m
  F alpha;
  F feature[3];
#if SIM_REPLAY
  F place;  // of the particle in the tile's list
#endif
} Met;

/// Moves `met` in front of `before` in lanes where it is nearer: `place` gets the farther of the two, `met` the
/// other.
FN void pass_by(I nearer, const Met* before, Met* place, Met* met) {
  const Met was = *met;
  place->tau = SEL(nearer, before->tau, was.tau);
  met->tau = SEL(nearer, was.tau, before->tau);
  place->alpha = SEL(nearer, before->alpha, was.alpha);
  met->alpha = SEL(nearer, was.alpha, before->alpha);
  SIM_EACH(c, 3) {
    place->feature[c] = SEL(nearer, before->feature[c], was.feature[c]);
    met->feature[c] = SEL(nearer, was.feature[c], before->feature[c]);
  }
#if SIM_REPLAY
  place->place = SEL(nearer, before->place, was.place);
  met->place = SEL(nearer, was.place, before->place);
#endif
}

/// Copies through pointers, member by member; see load_ray().
FN void copy_met(const Met* from, Met* to) {
  to->tau = from->tau;
  to->alpha = from->alpha;
  SIM_EACH(c, 3) to->feature[c] = from->feature[c];
#if SIM_REPLAY
  to->place = from->place;
#endif
}

/// Features and list position of the pair as seen along d.
FN void describe_met(const TilePair* at, const Features* features, const F* d, Met* met) {
#if SIM_REPLAY
  met->place = (F)(real)at->place;
#endif
#if ACTOR_IDS
  met->feature[0] = (F)(real)features->actor_of[at->particle];
  met->feature[1] = met->feature[2] = (F)R(0.0);
#elif RAY_SH
  ray_feature(features, at->particle, d, met->feature);
#else
  SIM_EACH(c, 3) met->feature[c] = (F)at->record[SIM_R_FEATURE + c];
#endif
}

#endif
