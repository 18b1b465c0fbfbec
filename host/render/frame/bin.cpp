// Launcher of "kernels/bin.cl".
#include <algorithm>
#include <bit>
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/render/frame/stages.hpp"

namespace simuli {

Chunks chunks_of(const Device& device, std::size_t n) {
  const std::size_t target = device.info().compute_units * (device.info().is_cpu ? 4U : 256U);
  const std::size_t chunk = std::max<std::size_t>(16, (n + target - 1) / target);
  return {(n + chunk - 1) / chunk, static_cast<std::uint32_t>(chunk)};
}

BinStage::BinStage(const Device& device)
    : device_(device),
      visible_count_(Program(device, "kernels/bin.cl"), "visible_count"),
      visible_write_(Program(device, "kernels/bin.cl"), "visible_write"),
      instance_count_(Program(device, "kernels/bin.cl"), "instance_count"),
      instance_emit_(Program(device, "kernels/bin.cl"), "instance_emit"),
      tile_ranges_(Program(device, "kernels/bin.cl"), "tile_ranges") {}

void BinStage::run(const shared::FrameParams& frame,
                   const Buffer<std::uint32_t>& tile_rows,
                   FrameBuffers& b,
                   SortStage& sort,
                   ScanStage& scan,
                   std::size_t max_instances) {
  const std::uint32_t n = frame.particles;
  const std::uint32_t tiles = frame.tiles_x * frame.tiles_y;
  b.first.reserve(std::size_t{tiles} + 1);
  b.emission.reserve(n);
  b.visible = 0;
  b.instances = 0;

  const Chunks particles = chunks_of(device_, n);
  if (n > 0) {
    b.counts.reserve(particles.work_items);
    visible_count_.launch(particles.work_items, 1, b.keys, n, particles.chunk, b.counts);
    b.visible = static_cast<std::uint32_t>(
        scan.run(b.counts, static_cast<std::uint32_t>(particles.work_items), true));
    b.order.reserve(b.visible);
    b.order_keys.reserve(b.visible);
    visible_write_.launch(
        particles.work_items, 1, b.keys, n, particles.chunk, b.counts, b.order_keys, b.order);
  }
  // Once by range; instances inherit the order, so that tiles need only their own bits sorted.
  sort.run(b.order_keys, b.order, b.key_scratch, b.value_scratch, b.visible, 32, scan);

  if (b.visible > 0) {
    const Chunks visible = chunks_of(device_, b.visible);
    b.counts.reserve(visible.work_items);
    instance_count_.launch(visible.work_items, 1, b.order, b.visible, visible.chunk, b.footprints, b.counts);
    const std::uint64_t total = scan.run(b.counts, static_cast<std::uint32_t>(visible.work_items), true);
    if (total > max_instances) {
      throw Error(ErrorKind::kDevice,
                  fmt::format("binning {} visible particles: found {} tile instances, allowed {}",
                              b.visible,
                              total,
                              max_instances));
    }
    b.instances = static_cast<std::uint32_t>(total);
    b.tile.reserve(b.instances);
    b.payload.reserve(b.instances);
    instance_emit_.launch(visible.work_items,
                          1,
                          frame,
                          b.order,
                          b.visible,
                          visible.chunk,
                          b.footprints,
                          tile_rows,
                          b.counts,
                          b.tile,
                          b.payload,
                          b.emission);
    sort.run(b.tile, b.payload, b.key_scratch, b.value_scratch, b.instances, std::bit_width(tiles - 1), scan);
  }
  const Chunks instances = chunks_of(device_, b.instances);
  tile_ranges_.launch(std::max<std::size_t>(instances.work_items, 1),
                      1,
                      b.tile,
                      b.instances,
                      instances.chunk,
                      tiles,
                      b.first);
}

}  // namespace simuli
