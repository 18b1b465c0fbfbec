#pragma once
// What is plausible where nobody has looked: rows of rays go on from what is beside the gap.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace simuli {

/// What the rays of one frame meet without actors. Row-major: pixels, or beams and their firings.
struct RayRows {
  std::size_t rows = 0, columns = 0;
  bool closed = false;                         // the last column's neighbour is the first
  std::size_t around = 3;                      // rays beside a gap among which what goes on behind it is
  std::vector<std::uint32_t> actor;            // [rays] that stands before it, 1 + its index; 0: none
  std::vector<float> range_m;                  // [rays] 0: nothing, +inf: too far to tell
  std::vector<std::array<float, 3>> features;  // [rays] colour; or intensity and two that don't count

  [[nodiscard]] std::size_t rays() const { return rows * columns; }
  [[nodiscard]] bool is_hole(std::size_t ray) const { return actor[ray] != 0 && !(range_m[ray] > 0.0F); }
};

struct FilledRay {
  std::size_t ray = 0;
  float range_m = 0.0F;
  std::array<float, 3> features{};
};

/// The rays of gaps behind actors that end, in their row, at something on at least one side. Between two
/// sides that a plane can join 1 / range goes on linearly, as it does on a plane in a pinhole's picture; of
/// two that none joins the farther one goes on, as something nearer would have an edge somewhere else; so
/// does, of what is `around` a side, what is farther than the rest. Beside open sky the near half is what the
/// side is.
[[nodiscard]] std::vector<FilledRay> inpaint_rows(const RayRows& frame);

/// Actors reach that many columns and rows farther: what is next to one is a mixture.
void widen_actors(RayRows& frame, int by);

}  // namespace simuli
