#pragma once
// Procedural patterns of the synthetic streets, for io/synth/street_*.cpp.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "io/synth/street_world.hpp"

namespace simuli::street_pattern {

inline std::uint64_t mix(std::uint64_t x) {  // the finaliser of SplitMix64
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

/// Returns a uniform number in [0,1) for a lattice point.
inline double hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  std::uint64_t h = mix(seed + 0x9e3779b97f4a7c15ULL);
  h = mix(h ^ static_cast<std::uint64_t>(x));
  h = mix(h ^ static_cast<std::uint64_t>(y));
  h = mix(h ^ static_cast<std::uint64_t>(z));
  return static_cast<double>(h >> 11U) * 0x1.0p-53;
}

/// Returns smooth value noise in [-1, 1] with features of one unit.
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

/// Returns two octaves of noise: patches of `size_m` and of a quarter of it.
inline double patches(const Eigen::Vector3d& p, double size_m, std::uint64_t seed) {
  return 0.7 * noise(p / size_m, seed) + 0.3 * noise(p * (4.0 / size_m), seed + 1);
}

inline double wrap(double x, double period) { return x - period * std::floor(x / period); }

/// Returns the index of the period of length `size` that contains x.
inline std::int64_t cell(double x, double size = 1.0) {
  return static_cast<std::int64_t>(std::floor(x / size));
}

inline StreetSurface scaled(const Eigen::Vector3d& tint, double reflectance, double brightness) {
  return {tint * brightness, std::clamp(reflectance * brightness, 0.0, 1.0)};
}

inline StreetSurface glass(double brightness) {
  return {Eigen::Vector3d(0.16, 0.22, 0.30) * brightness, 0.0};
}

}  // namespace simuli::street_pattern
