// random.h - counter-based random numbers: Philox4x32-10 of Salmon et al., "Parallel random numbers: as easy as
// 1, 2, 3" (SC 2011). One text for device and host. A number is a function of key and counter, so any number
// can be generated in any order and repeatedly.
#ifndef SIMULI_CL_MATH_RANDOM_H
#define SIMULI_CL_MATH_RANDOM_H
#ifdef __cplusplus
#include <cstdint>
namespace simuli::shared {
using sim_u32 = std::uint32_t;
using sim_u64 = std::uint64_t;
#define RANDOM_FN inline
#else
#include "math/lanes.h"
#include "shared/layout.h"
typedef ulong sim_u64;
#define RANDOM_FN FN
#endif

/// Purposes of random numbers, the third word of the counter. The first two are particle and iteration, the
/// fourth the set.
#define RANDOM_SOURCE 1u  // source particle of a copy
#define RANDOM_NOISE 2u   // noise on means

typedef struct {
  sim_u32 word[4];
} Random4;

/// Four uniform 32-bit words from a 64-bit key and a 128-bit counter.
RANDOM_FN Random4
philox(sim_u32 key0, sim_u32 key1, sim_u32 counter0, sim_u32 counter1, sim_u32 counter2, sim_u32 counter3) {
  Random4 x;
  x.word[0] = counter0;
  x.word[1] = counter1;
  x.word[2] = counter2;
  x.word[3] = counter3;
  for (int round = 0; round < 10; ++round) {
    const sim_u64 even = (sim_u64)0xD2511F53u * x.word[0];
    const sim_u64 odd = (sim_u64)0xCD9E8D57u * x.word[2];
    const sim_u32 second = x.word[1], fourth = x.word[3];
    x.word[0] = (sim_u32)(odd >> 32) ^ second ^ key0;
    x.word[1] = (sim_u32)odd;
    x.word[2] = (sim_u32)(even >> 32) ^ fourth ^ key1;
    x.word[3] = (sim_u32)even;
    key0 += 0x9E3779B9u;  // golden ratio - 1 and sqrt(3) - 1, scaled to 32 bits
    key1 += 0xBB67AE85u;
  }
  return x;
}

#ifdef __cplusplus
}  // namespace simuli::shared
#undef RANDOM_FN
#else
/// Uniform in (0, 1), both ends excluded: the upper 24 bits, which a float represents exactly.
FN real uniform_of(uint word) { return ((real)(word >> 8) + R(0.5)) * R(5.9604644775390625e-8); }

/// Three standard normal numbers (Box-Muller).
FN void normals_of(Random4 random, real* normal) {
  for (int pair = 0; pair < 2; ++pair) {
    const real radius = sqrt(R(-2.0) * log(uniform_of(random.word[2 * pair])));
    const real turn = R(6.28318530717958647693) * uniform_of(random.word[2 * pair + 1]);
    normal[2 * pair] = radius * cos(turn);
    if (pair == 0) normal[1] = radius * sin(turn);
  }
}
#endif
#endif
