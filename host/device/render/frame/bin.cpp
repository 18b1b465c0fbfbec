// Launcher of "kernels/bin.cl".
#include <algorithm>
#include <bit>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "host/device/render/frame/stages.hpp"

namespace simuli {
namespace {

Program program_of(const Device& device, std::size_t group) {
  return {device, "kernels/bin.cl", BuildOptions().define("LS", group)};
}

}  // namespace

BinStage::BinStage(const Device& device, std::size_t work_items)
    : device_(device),
      group_(chunks_of(device, 0, work_items).group),
      scan_(device, work_items),
      sort_(device, work_items),
      scratch_(device),
      visible_count_(program_of(device, group_), "visible_count"),
      visible_write_(program_of(device, group_), "visible_write"),
      pair_count_(program_of(device, group_), "pair_count"),
      pair_emit_(program_of(device, group_), "pair_emit"),
      tile_ranges_(program_of(device, group_), "tile_ranges") {}

void BinStage::run(const shared::FrameParams& frame,
                   const ParticleBuffers& particles,
                   const RayBuffers& rays,
                   const Projected& projected,
                   std::size_t max_pairs,
                   Binned& out) {
  const std::uint32_t tiles = frame.tiles_x * frame.tiles_y;
  FrameSizes sizes{.particles = frame.particles, .tiles = tiles};
  out.visible = 0;
  out.pairs = 0;
  if (frame.particles > 0) list_visible(particles, projected, max_pairs, sizes, out);
  out.reserve(sizes);
  if (out.visible > 0) list_pairs(frame, rays, projected, sizes, out);
  const Chunks pairs = chunks_of(device_, out.pairs, group_);
  tile_ranges_.run(std::max(pairs.work_items, group_),
                   group_,
                   {out, {"k", out.pairs}, {"chunk", pairs.chunk}, {"tiles", tiles}});
}

void BinStage::list_visible(const ParticleBuffers& particles,
                            const Projected& projected,
                            std::size_t max_pairs,
                            FrameSizes& sizes,
                            Binned& out) {
  const auto n = static_cast<std::uint32_t>(sizes.particles);
  const Chunks chunks = chunks_of(device_, n, group_);
  const std::uint32_t paged = particles.paged ? 1 : 0;
  sizes.work_items = chunks.work_items;
  scratch_.reserve(sizes);
  visible_count_.run(chunks.work_items,
                     group_,
                     {projected, particles, {"paged", paged}, {"n", n}, {"chunk", chunks.chunk}, scratch_});
  const auto [visible, total] = scan_.run_two(scratch_.counts, static_cast<std::uint32_t>(chunks.work_items));
  if (total > max_pairs) {
    throw Error(ErrorKind::kDevice,
                fmt::format("binning {} visible particles: found {} tile instances, allowed {}",
                            visible,
                            total,
                            max_pairs));
  }
  out.visible = visible;
  out.pairs = static_cast<std::uint32_t>(total);
  sizes.visible = visible;
  sizes.pairs = total;
  scratch_.reserve(sizes);
  out.reserve(sizes);
  visible_write_.run(chunks.work_items,
                     group_,
                     {projected,
                      particles,
                      {"paged", paged},
                      {"n", n},
                      {"chunk", chunks.chunk},
                      {"offsets", scratch_.counts},
                      scratch_,
                      {"visible", out.order}});
  // Sorts particles once by range; pairs inherit the order, so that only their tile bits need sorting.
  sort_.run(scratch_.visible_keys, out.order, out.visible, 32);
}

void BinStage::list_pairs(const shared::FrameParams& frame,
                              const RayBuffers& rays,
                              const Projected& projected,
                              FrameSizes& sizes,
                              Binned& out) {
  const Chunks visible = chunks_of(device_, out.visible, group_);
  sizes.work_items = visible.work_items;
  scratch_.reserve(sizes);
  pair_count_.run(
      visible.work_items, group_, {out, {"m", out.visible}, {"chunk", visible.chunk}, projected, scratch_});
  scan_.run(scratch_.counts, static_cast<std::uint32_t>(visible.work_items), false);
  pair_emit_.run(visible.work_items,
                     group_,
                     {{"frame", frame},
                      out,
                      {"m", out.visible},
                      {"chunk", visible.chunk},
                      projected,
                      rays,
                      {"offsets", scratch_.counts}});
  sort_.run(out.tile, out.payload, out.pairs, std::bit_width(frame.tiles_x * frame.tiles_y - 1));
}

}  // namespace simuli
