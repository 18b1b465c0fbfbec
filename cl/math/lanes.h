// lanes.h - one source for CPU vectors and GPU work-items.
// V lanes per vector, NR vectors per work-item, LS work-items per tile: V * NR * LS = 256 rays. F is a vector
// of V reals, I the integer vector of the same width. True is 1 in scalars and -1 in vectors, so masks are used
// only through SEL, ANY, AND, OR and NOT.
#ifndef SIMULI_CL_MATH_LANES_H
#define SIMULI_CL_MATH_LANES_H

// No automatic contraction, because forward and backward must round alike; fma() is explicit.
#pragma OPENCL FP_CONTRACT OFF

#define LANES_CAT_(a, b) a##b
#define LANES_CAT(a, b) LANES_CAT_(a, b)

#ifdef SIMULI_KEEP_CALLS
// Oclgrind 21.10 fails at llvm.experimental.noalias.scope.decl, which inlining leaves behind: it needs this
// definition and -cl-opt-disable (bench/drivers.py).
#define FN static
#else
// CPU drivers otherwise keep long functions out of line and pass vectors through memory.
#define FN inline __attribute__((always_inline))
#endif

#ifdef SIMULI_REAL_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#define REAL_(x) x
#define REAL_VECTOR(n) LANES_CAT(double, n)
#else
typedef float real;
#define REAL_(x) x##f
#define REAL_VECTOR(n) LANES_CAT(float, n)
#endif
// R(1.5) is a constant of the build's precision.
#define R(x) REAL_(x)

#ifndef V
#define V 1
#endif

// An unrolled loop over a few indices. PoCL does not unroll by itself and keeps indexed arrays in memory.
#define SIM_EACH(k, n) _Pragma("unroll") for (int k = 0; k < (n); ++k)

// Kernels launched in groups of LS; otherwise drivers plan registers for groups of any size.
#if LS > 1
#define SIM_GROUP __attribute__((reqd_work_group_size(LS, 1, 1)))
#else
#define SIM_GROUP
#endif

#if V == 1
typedef real F;
typedef int I;
#define LDV(p) (*(p))
#define STV(p, v) (*(p) = (v))
#define TO_INTS(v) ((int)(v))
#define SEL(c, a, b) ((c) ? (a) : (b))
#define ANY(c) (c)
#define AND(a, b) ((a) && (b))
#define OR(a, b) ((a) || (b))
#define HSUM(v) (v)
#define HMAX(v) (v)
#else
#ifdef SIMULI_REAL_DOUBLE
typedef REAL_VECTOR(V) F;
typedef LANES_CAT(long, V) I;
#else
typedef REAL_VECTOR(V) F;
typedef LANES_CAT(int, V) I;
#endif
#define LDV(p) LANES_CAT(vload, V)(0, (p))
#define STV(p, v) LANES_CAT(vstore, V)((v), 0, (p))
#define TO_INTS(v) LANES_CAT(convert_int, V)(v)
#define SEL(c, a, b) ((c) ? (a) : (b))
#define AND(a, b) ((a) & (b))
#define OR(a, b) ((a) | (b))

// any() compiles to a chain of extractions on CPUs; the reduction builtin is one instruction.
#ifdef __has_builtin
#if __has_builtin(__builtin_reduce_or)
#define ANY(c) (__builtin_reduce_or(c) != 0)
#endif
#endif
#ifndef ANY
#define ANY(c) any(c)
#endif

// Sum of the lanes, by halves, in the same order on every device; and their largest value, without NaN.
#if V == 16
#define HSUM(v) hsum16(v)
#define HMAX(v) hmax16(v)
#elif V == 8
#define HSUM(v) hsum8(v)
#define HMAX(v) hmax8(v)
#elif V == 4
#define HSUM(v) hsum4(v)
#define HMAX(v) hmax4(v)
#endif
#if V >= 4
FN real hsum4(REAL_VECTOR(4) v) { return (v.s0 + v.s2) + (v.s1 + v.s3); }
FN real hmax4(REAL_VECTOR(4) v) { return fmax(fmax(v.s0, v.s2), fmax(v.s1, v.s3)); }
#endif
#if V >= 8
FN real hsum8(REAL_VECTOR(8) v) { return hsum4(v.lo + v.hi); }
FN real hmax8(REAL_VECTOR(8) v) { return hmax4(fmax(v.lo, v.hi)); }
#endif
#if V >= 16
FN real hsum16(F v) { return hsum8(v.lo + v.hi); }
FN real hmax16(F v) { return hmax8(fmax(v.lo, v.hi)); }

/// Transposes 16 vectors to out[16][16]: each step exchanges halves of two rows that are 8, 4, 2 and 1 apart.
FN void transpose16(const F* rows, real* out) {
  F a[16], b[16];
  SIM_EACH(k, 8) {
    const F p = rows[k], q = rows[k + 8];
    a[k] = (F)(p.lo, q.lo);
    a[k + 8] = (F)(p.hi, q.hi);
  }
#pragma unroll
  for (int k = 0; k < 16; k += 8) {
#pragma unroll
    for (int j = k; j < k + 4; ++j) {
      const F p = a[j], q = a[j + 4];
      b[j] = (F)(p.s0123, q.s0123, p.s89ab, q.s89ab);
      b[j + 4] = (F)(p.s4567, q.s4567, p.scdef, q.scdef);
    }
  }
#pragma unroll
  for (int k = 0; k < 16; k += 4) {
#pragma unroll
    for (int j = k; j < k + 2; ++j) {
      const F p = b[j], q = b[j + 2];
      a[j] = (F)(p.s01, q.s01, p.s45, q.s45, p.s89, q.s89, p.scd, q.scd);
      a[j + 2] = (F)(p.s23, q.s23, p.s67, q.s67, p.sab, q.sab, p.sef, q.sef);
    }
  }
#pragma unroll
  for (int k = 0; k < 16; k += 2) {
    const F p = a[k], q = a[k + 1];
    STV(out + k * 16,
        (F)(p.s0, q.s0, p.s2, q.s2, p.s4, q.s4, p.s6, q.s6, p.s8, q.s8, p.sa, q.sa, p.sc, q.sc, p.se, q.se));
    STV(out + k * 16 + 16,
        (F)(p.s1, q.s1, p.s3, q.s3, p.s5, q.s5, p.s7, q.s7, p.s9, q.s9, p.sb, q.sb, p.sd, q.sd, p.sf, q.sf));
  }
}

/// hsum16() of each of 16 vectors with the same bits, in 15 instead of 64 additions, adding halves of two
/// vectors at a time.
FN F hsum16_each(const F* v) {
  F a[8], b[4], c[2];
  SIM_EACH(k, 8) a[k] = (F)(v[k].lo, v[k + 8].lo) + (F)(v[k].hi, v[k + 8].hi);
  SIM_EACH(k, 4) {
    const F p = a[k], q = a[k + 4];
    b[k] = (F)(p.s0123, q.s0123, p.s89ab, q.s89ab) + (F)(p.s4567, q.s4567, p.scdef, q.scdef);
  }
  SIM_EACH(k, 2) {
    const F p = b[k], q = b[k + 2];
    c[k] = (F)(p.s01, q.s01, p.s45, q.s45, p.s89, q.s89, p.scd, q.scd) +
           (F)(p.s23, q.s23, p.s67, q.s67, p.sab, q.sab, p.sef, q.sef);
  }
  const F p = c[0], q = c[1];
  return (F)(p.s0, q.s0, p.s2, q.s2, p.s4, q.s4, p.s6, q.s6, p.s8, q.s8, p.sa, q.sa, p.sc, q.sc, p.se, q.se) +
         (F)(p.s1, q.s1, p.s3, q.s3, p.s5, q.s5, p.s7, q.s7, p.s9, q.s9, p.sb, q.sb, p.sd, q.sd, p.sf, q.sf);
}
#endif
#endif

#define NOT(c) ((c) == 0)
#define VMIN(a, b) SEL((a) < (b), (a), (b))
#define VMAX(a, b) SEL((a) > (b), (a), (b))

// CPUs only: Intel's GPU compiler has the builtin but cannot translate it.
#if defined(__x86_64__) || defined(__aarch64__) || defined(__powerpc64__) || defined(__riscv)
#if defined(__has_builtin)
#if __has_builtin(__builtin_prefetch)
#define SIM_PREFETCH(p) __builtin_prefetch(p)
#endif
#endif
#endif
#ifndef SIM_PREFETCH
#define SIM_PREFETCH(p)
#endif
// Prefetch distance in list entries for scattered data, about a memory latency.
#define SIM_AHEAD 12

#endif
