// window.h - the last responses of a vector that it has not blended yet, in its rays' own order. Behind light.h or
// light_bwd.h, whose blend() it calls.
// Build: WINDOW entries, 2 or more.
#ifndef SIMULI_CL_MATH_WINDOW_H
#define SIMULI_CL_MATH_WINDOW_H
#include "math/met.h"

/// What the rays of one vector have met and not blended yet, nearest first: entry i of all that were ever put
/// in came to i % WINDOW.
typedef struct {
  Met entry[WINDOW];
  uint count;  // ever put in
} Window;

/// Puts `met` in; where the window is full, its nearest has been blended before. A list by range is nearly in order:
/// most stay where they come in, at the far end.
FN void put(Window* w, Met* met) {
  uint k = w->count++;
  const uint nearest = k < WINDOW ? 0 : k - (WINDOW - 1);
  for (; k > nearest; --k) {
    const Met* before = &w->entry[(k - 1) % WINDOW];
    const I nearer = met->tau < before->tau;
    if (!ANY(nearer)) break;
    pass_by(nearer, before, &w->entry[k % WINDOW], met);
  }
  copy_met(met, &w->entry[k % WINDOW]);
}

/// Puts in what the rays `inside` along d meet of the pair.
FN void put_pair(Window* w,
                     const Tile* tile,
                     const TilePair* at,
                     const Response* response,
                     I inside,
                     const Features* features,
                     const F* d) {
  Met met;
  const F last = w->count > 0 ? w->entry[(w->count - 1) % WINDOW].tau : (F)R(0.0);
  met.tau = SEL(inside, response->tau, last);
  met.alpha = alpha_of(inside, at->record, response->q, tile->log_cut);
  describe_met(at, features, d, &met);
  put(w, &met);
}

/// Makes room in a full window for what the rays `inside` meet.
FN void blend_nearest(const Window* w, I inside, real t_cut, Light* light) {
  if (w->count >= WINDOW && ANY(inside)) blend(&w->entry[w->count % WINDOW], t_cut, light);
}

FN void blend_rest(const Window* w, real t_cut, Light* light) {
  for (uint i = w->count < WINDOW ? 0 : w->count - WINDOW; i < w->count; ++i) {
    if (!ANY(light->going)) break;
    blend(&w->entry[i % WINDOW], t_cut, light);
  }
}

#endif
