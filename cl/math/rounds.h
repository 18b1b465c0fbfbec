// rounds.h - exact order along each ray: a vector processes its tile's list in rounds, each of which blends the
// nearest responses beyond those of the last round; the next round starts at the first response left over.
// Include after light.h or light_bwd.h, whose blend() it calls.
#ifndef SIMULI_CL_MATH_ROUNDS_H
#define SIMULI_CL_MATH_ROUNDS_H
#include "math/met.h"

// Responses of a vector per round. GPUs keep them in scratch memory for every resident work-item.
#if LS == 1
#define SIM_ROUND 128
#else
#define SIM_ROUND 16
#endif

/// A round of V rays: the nearest responses beyond those of the last round.
typedef struct {
  Met entry[SIM_ROUND];
  F place[SIM_ROUND];  // position in the tile's list
  uint count;
  F last_tau, last_place;  // of the last round
  F left_over;             // first list position for the next round
} Round;

/// Inserts the response of the rays `ahead` at list position `place`. A full round drops its farthest response.
FN void put_ahead(Round* round, I ahead, F place, Met* met) {
  uint k = round->count;
  const uint last = k - 1;
  met->tau = SEL(ahead, met->tau, k > 0 ? round->entry[last].tau : round->last_tau);
  met->alpha = SEL(ahead, met->alpha, (F)R(0.0));
  place = SEL(ahead, place, k > 0 ? round->place[last] : round->last_place);
  if (k < SIM_ROUND) {
    ++round->count;
  } else {
    Met dropped;
    const I nearer = met->tau < round->entry[last].tau;
    const F dropped_place = SEL(nearer, round->place[last], place);
    place = SEL(nearer, place, round->place[last]);
    pass_by(nearer, &round->entry[last], &dropped, met);
    round->left_over = SEL(dropped.alpha > R(0.0), VMIN(round->left_over, dropped_place), round->left_over);
    k = last;
  }
  for (; k > 0; --k) {
    const I nearer = met->tau < round->entry[k - 1].tau;
    if (!ANY(nearer)) break;
    round->place[k] = SEL(nearer, round->place[k - 1], place);
    place = SEL(nearer, place, round->place[k - 1]);
    pass_by(nearer, &round->entry[k - 1], &round->entry[k], met);
  }
  round->place[k] = place;
  copy_met(met, &round->entry[k]);
}

/// Fills a round with the responses of vector j from list position `begin` on.
FN void gather(const Tile* tile,
               const Features* features,
               const RayLanes* ray,
               int j,
               I going,
               uint begin,
               Round* round) {
  const uint count = tile->end - tile->begin;
  round->count = 0;
  round->left_over = (F)(real)count;
  for (uint i = begin; i < count; ++i) {
    const uint packed = tile->payload[tile->begin + i];
    if (!touches(rows_of(packed), j, tile->lid)) continue;
    TilePair at;
    load_pair(tile, i, &at);
    RayLanes own;
    Response response;
    meet(tile, &at, seen_by(&at, ray, &own), &response);
    Met met;
    met.tau = response.tau;
    const F place = (F)(real)i;
    const I behind =
        OR(met.tau > round->last_tau, AND(met.tau == round->last_tau, place > round->last_place));
    const I ahead = AND(AND(response.inside, going), behind);
    if (!ANY(ahead)) continue;
    if (round->count == SIM_ROUND && !ANY(AND(ahead, met.tau < round->entry[SIM_ROUND - 1].tau))) {
      round->left_over = SEL(ahead, VMIN(round->left_over, place), round->left_over);
      continue;
    }
    // put_ahead() uses alpha only for rays ahead.
    met.alpha =
        VMIN(raw_alpha(at.record, SEL(ahead, response.q, (F)R(0.0)), tile->log_cut), (F)SIM_ALPHA_MAX);
    describe_met(&at, features, ray->d, &met);
    put_ahead(round, ahead, place, &met);
  }
}

/// Blends all responses of vector j by their distance along each ray, ties by list position. Exact for lists of
/// up to 2^24 entries.
FN void blend_in_rounds(
    const Tile* tile, const Features* features, const RayLanes* ray, int j, Light* light) {
  const uint count = tile->end - tile->begin;
  Round round;
  round.last_tau = round.last_place = (F)R(-1.0);
  uint begin = 0;
  while (begin < count && ANY(light->going)) {
    gather(tile, features, ray, j, light->going, begin, &round);
    if (round.count == 0) break;
    for (uint k = 0; k < round.count && ANY(light->going); ++k) blend(&round.entry[k], tile->t_cut, light);
    round.last_tau = round.entry[round.count - 1].tau;
    round.last_place = round.place[round.count - 1];
    real places[V];
    STV(places, SEL(light->going, round.left_over, (F)(real)count));
    begin = count;
    SIM_EACH(lane, V) begin = min(begin, (uint)places[lane]);
  }
}

#endif
