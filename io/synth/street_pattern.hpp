#pragma once
// What the patterns of the synthetic streets are made of. Included by io/synth/street_*.cpp alone.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "io/synth/street_world.hpp"

namespace simuli::street_pattern {

inline std::uint64_t mix(std::uint64_t x) {  // the finaliser of SplitMix64
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

/// Uniform in [0,1) from a lattice point.
inline double hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  std::uint64_t h = mix(seed + 0x9e3779b97f4a7c15ULL);
  h = mix(h ^ static_cast<std::uint64_t>(x));
  h = mix(h ^ static_cast<std::uint64_t>(y));
  h = mix(h ^ static_cast<std::uint64_t>(z));
  return static_cast<double>(h >> 11U) * 0x1.0p-53;
}

/// Smooth value noise in [-1, 1] with features of one unit.
inline double noise(const Eigen::Vector3d& p, std::uint64_t seed) {
  const Eigen::Vector3d base = p.array().floor();
  const Eigen::Vector3d f = p - base;
  const Eigen::Vector3d w = f.array().square() * (3.0 - 2.0 * f.array());
  const auto x = static_cast<std::int64_t>(base.x());
  const auto y = static_cast<std::int64_t>(base.y());
  const auto z = static_cast<std::int64_t>(base.z());
  const auto along_x = [&](std::int64_t dy, std::int64_t dz) {
    return std::lerp(hash(x, y + dy, z + dz, seed), hash(x + 1, y + dy, z + dz, seed), w.x());
  };
  const double low = std::lerp(along_x(0, 0), along_x(1, 0), w.y());
  const double high = std::lerp(along_x(0, 1), along_x(1, 1), w.y());
  return 2.0 * std::lerp(low, high, w.z()) - 1.0;
}

/// Two octaves: broad patches of `size_m` and finer ones of a quarter of it.
inline double patches(const Eigen::Vector3d& p, double size_m, std::uint64_t seed) {
  return 0.7 * noise(p / size_m, seed) + 0.3 * noise(p * (4.0 / size_m), seed + 1);
}

inline double wrap(double x, double period) { return x - period * std::floor(x / period); }

/// Which period of `size` x is in.
inline std::int64_t cell(double x, double size = 1.0) {
  return static_cast<std::int64_t>(std::floor(x / size));
}

inline StreetSurface scaled(const Eigen::Vector3d& tint, double reflectance, double brightness) {
  return {tint * brightness, std::clamp(reflectance * brightness, 0.0, 1.0)};
}

inline StreetSurface glass(double brightness) {
  return {Eigen::Vector3d(0.16, 0.22, 0.30) * brightness, 0.0};
}

// Below: the detailed street's alone.

/// From 0 at `low` to 1 at `high`, smooth.
inline double ease(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// How much of the contrast of a pattern whose parts are size_m wide is left in pixels of footprint_m: all
/// where parts are larger than pixels, none where they are half as large. What pixels can't tell apart they
/// show as its mean.
inline double fine(double size_m, double footprint_m) {
  return footprint_m <= 0.0 ? 1.0 : std::clamp(2.0 * size_m / footprint_m - 1.0, 0.0, 1.0);
}

/// Whether there is ink at (u, v) of a text: u in letters from its left end, v in [0, 1) from below. Letters
/// are 3 x 5 dots, with one free dot between them.
inline bool ink(std::string_view text, double u, double v) {
  struct Letter {
    char name;
    std::uint16_t rows;  // 5 x 3 bits, the top left first
  };
  static constexpr std::array<Letter, 26> kLetters{
      {{'A', 025755}, {'B', 065656}, {'C', 034443}, {'E', 074647}, {'H', 055755}, {'I', 022222},
       {'K', 055655}, {'L', 044447}, {'M', 057755}, {'N', 065555}, {'O', 075557}, {'P', 065644},
       {'R', 065655}, {'S', 034216}, {'T', 072222}, {'U', 055557}, {'0', 025552}, {'1', 026227},
       {'2', 061247}, {'3', 061216}, {'4', 055711}, {'5', 074616}, {'6', 034757}, {'7', 071222},
       {'8', 025252}, {'9', 075716}}};
  if (!(u >= 0.0 && v >= 0.0 && v < 1.0) || u >= static_cast<double>(text.size())) return false;
  const char name = text[static_cast<std::size_t>(u)];
  const int column = static_cast<int>(4.0 * (u - std::floor(u))), row = 4 - static_cast<int>(5.0 * v);
  if (column > 2) return false;
  const auto* const letter =
      std::find_if(kLetters.begin(), kLetters.end(), [&](const Letter& l) { return l.name == name; });
  return letter != kLetters.end() && ((letter->rows >> (3 * (4 - row) + (2 - column))) & 1U) != 0;
}

}  // namespace simuli::street_pattern
