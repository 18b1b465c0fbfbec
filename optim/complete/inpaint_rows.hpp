#pragma once
// Inpaints gaps along rows of rays from the surfaces on both sides.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace simuli {

/// Results of one frame's rays without actors. Row-major: pixels, or beams and firings.
struct RayRows {
  std::size_t rows = 0, columns = 0;
  bool closed = false;  // the last column is adjacent to the first
  std::size_t around = 3;  // rays next to a gap among which the continued surface is searched
  std::vector<std::uint32_t> actor;  // [rays] occluding actor, 1 + its index; 0: none
  std::vector<float> range_m;  // [rays] 0: nothing, +inf: unknown large distance
  std::vector<std::array<float, 3>> features;  // [rays] colour; or intensity and two unused values

  [[nodiscard]] std::size_t rays() const { return rows * columns; }
  [[nodiscard]] bool is_hole(std::size_t ray) const { return actor[ray] != 0 && !(range_m[ray] > 0.0F); }
};

struct FilledRay {
  std::size_t ray = 0;
  float range_m = 0.0F;
  std::array<float, 3> features{};
};

/// Returns the rays of gaps behind actors that end at a surface on at least one side of their row. Between two
/// sides that a plane can join, 1 / range is linear, as on a plane in a pinhole picture; otherwise the farther
/// surface continues, because a nearer one would have a visible edge; likewise the farther of the surfaces
/// within `around` of one side. Next to open sky the near half takes the other side's surface.
[[nodiscard]] std::vector<FilledRay> inpaint_rows(const RayRows& frame);

/// Extends actors by that many columns and rows, because adjacent rays are mixtures.
void widen_actors(RayRows& frame, int by);

}  // namespace simuli
