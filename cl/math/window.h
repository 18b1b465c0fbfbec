// window.h - the latest unblended responses of a vector, sorted along its rays. Include after light.h or
// light_bwd.h, whose blend() it calls.
// Build: WINDOW entries, 2 or more.
#ifndef SIMULI_CL_MATH_WINDOW_H
#define SIMULI_CL_MATH_WINDOW_H
#include "math/met.h"

/// Unblended responses of the rays of one vector, nearest first: the i-th inserted entry is at i % WINDOW.
typedef struct {
  Met entry[WINDOW];
  uint count;  // number of inserted entries
} Window;

/// Inserts `met`; in a full window the nearest response must have been blended before. Lists by range are
/// nearly sorted, so most entries stay at the far end.
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

/// Inserts the responses of the rays `inside` along d to the pair.
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

/// Frees an entry of a full window for the responses of the rays `inside`.
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
