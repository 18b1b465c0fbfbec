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
      instance_count_(program_of(device, group_), "instance_count"),
      instance_emit_(program_of(device, group_), "instance_emit"),
      tile_ranges_(program_of(device, group_), "tile_ranges") {}

void BinStage::run(const shared::FrameParams& frame,
                   const ParticleBuffers& particles,
                   const RayBuffers& rays,
                   const Projected& projected,
                   std::size_t max_instances,
                   Binned& out) {
  const std::uint32_t tiles = frame.tiles_x * frame.tiles_y;
  FrameSizes sizes{.particles = frame.particles, .tiles = tiles};
  out.visible = 0;
  out.instances = 0;
  if (frame.particles > 0) list_visible(particles, projected, max_instances, sizes, out);
  out.reserve(sizes);
  if (out.visible > 0) list_instances(frame, rays, projected, sizes, out);
  const Chunks instances = chunks_of(device_, out.instances, group_);
  tile_ranges_.run(std::max(instances.work_items, group_),
                   group_,
                   {out, {"k", out.instances}, {"chunk", instances.chunk}, {"tiles", tiles}});
}

void BinStage::list_visible(const ParticleBuffers& particles,
                            const Projected& projected,
                            std::size_t max_instances,
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
  if (total > max_instances) {
    throw Error(ErrorKind::kDevice,
                fmt::format("binning {} visible particles: found {} tile instances, allowed {}",
                            visible,
                            total,
                            max_instances));
  }
  out.visible = visible;
  out.instances = static_cast<std::uint32_t>(total);
  sizes.visible = visible;
  sizes.instances = total;
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
  // Once by range; instances inherit the order, so that tiles need only their own bits sorted.
  sort_.run(scratch_.visible_keys, out.order, out.visible, 32);
}

void BinStage::list_instances(const shared::FrameParams& frame,
                              const RayBuffers& rays,
                              const Projected& projected,
                              FrameSizes& sizes,
                              Binned& out) {
  const Chunks visible = chunks_of(device_, out.visible, group_);
  sizes.work_items = visible.work_items;
  scratch_.reserve(sizes);
  instance_count_.run(
      visible.work_items, group_, {out, {"m", out.visible}, {"chunk", visible.chunk}, projected, scratch_});
  scan_.run(scratch_.counts, static_cast<std::uint32_t>(visible.work_items), false);
  instance_emit_.run(visible.work_items,
                     group_,
                     {{"frame", frame},
                      out,
                      {"m", out.visible},
                      {"chunk", visible.chunk},
                      projected,
                      rays,
                      {"offsets", scratch_.counts}});
  sort_.run(out.tile, out.payload, out.instances, std::bit_width(frame.tiles_x * frame.tiles_y - 1));
}

}  // namespace simuli
