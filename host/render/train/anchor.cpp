// Launcher of "kernels/anchor.cl".
#include "host/render/train/anchor.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 32;
constexpr std::size_t kWidth = 16;    // points of a leaf, children of a node
constexpr double kCells = 2097152.0;  // per axis: 21 bits

Program program(const Device& device, Precision precision, std::uint32_t neighbours) {
  BuildOptions options;
  return {device, "kernels/anchor.cl", options.real(precision).define("NEIGHBOURS", neighbours)};
}

std::size_t ceil_div(std::size_t n, std::size_t by) { return (n + by - 1) / by; }

}  // namespace

AnchorStage::AnchorStage(const Device& device, Precision precision, std::uint32_t neighbours)
    : device_(device),
      neighbours_(neighbours),
      scan_(device),
      sort_(device),
      candidates_(device, "anchor candidates"),
      nearest_(device, "anchors"),
      order_(device, "anchor order"),
      keys_(device, "anchor keys"),
      order_scratch_(device, "anchor order"),
      key_scratch_(device, "anchor keys"),
      ids_(device, "anchor points"),
      bounds_(device, "anchor bounds", precision),
      frame_(device, "anchor frame", precision),
      points_(device, "anchor points", precision),
      boxes_(device, "anchor boxes", precision),
      sums_(device, "anchor sums", precision),
      bounds_kernel_(program(device, precision, neighbours), "anchor_bounds"),
      keys_kernel_(program(device, precision, neighbours), "anchor_keys"),
      leaves_kernel_(program(device, precision, neighbours), "anchor_leaves"),
      nodes_kernel_(program(device, precision, neighbours), "anchor_nodes"),
      search_kernel_(program(device, precision, neighbours), "anchor_search"),
      loss_kernel_(program(device, precision, neighbours), "anchor_loss") {}

void AnchorStage::assign(const ParticleBuffers& set, const ParticleBuffers& targets, double reach_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::uint32_t n = targets.count;
  candidates_.reserve(std::size_t{set.count} * neighbours_);
  nearest_.reserve(set.count);
  if (n > 0) {
    const Chunks chunks = chunks_of(device_, n);
    bounds_.reserve(6 * chunks.work_items);
    bounds_kernel_.launch(chunks.work_items, 1, targets.params, targets.stride, n, chunks.chunk, bounds_);
    const std::vector<double> parts = bounds_.download_double();
    double low[3] = {kInfinity, kInfinity, kInfinity};
    double side = 0.0;
    for (std::size_t i = 0; i < parts.size(); i += 6) {
      for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], parts[i + k]);
    }
    for (std::size_t i = 0; i < parts.size(); i += 6) {
      for (std::size_t k = 0; k < 3; ++k) side = std::max(side, parts[i + 3 + k] - low[k]);
    }
    // Points in one place, or none: any cell will do.
    const double cells_per_m = side > 0.0 ? kCells / side : 1.0;
    frame_.assign(std::vector<double>{low[0], low[1], low[2], cells_per_m});

    order_.reserve(n);
    keys_.reserve(n);
    for (const std::uint32_t shift : {0U, 32U}) {
      keys_kernel_.launch(round_up(n, kLocalSize),
                          kLocalSize,
                          targets.params,
                          targets.stride,
                          n,
                          frame_,
                          shift,
                          order_,
                          keys_);
      sort_.run(keys_, order_, key_scratch_, order_scratch_, n, 32, scan_);
    }
    const std::size_t leaves = ceil_div(n, kWidth);
    std::vector<std::size_t> nodes = {ceil_div(leaves, kWidth)};  // by level
    std::size_t all = nodes[0];
    while (nodes.back() > 1) {
      nodes.push_back(ceil_div(nodes.back(), kWidth));
      all += nodes.back();
    }
    points_.reserve(leaves * 3 * kWidth);
    ids_.reserve(leaves * kWidth);
    boxes_.reserve(all * 6 * kWidth);
    boxes_.fill(std::numeric_limits<double>::quiet_NaN());
    leaves_kernel_.launch(round_up(leaves, kLocalSize),
                          kLocalSize,
                          targets.params,
                          targets.stride,
                          n,
                          order_,
                          points_,
                          ids_,
                          boxes_,
                          static_cast<std::uint32_t>(leaves));
    std::size_t first = 0;
    for (std::size_t level = 0; level + 1 < nodes.size(); ++level) {
      nodes_kernel_.launch(round_up(nodes[level], kLocalSize),
                           kLocalSize,
                           boxes_,
                           static_cast<std::uint32_t>(first),
                           static_cast<std::uint32_t>(nodes[level]),
                           static_cast<std::uint32_t>(first + nodes[level]));
      first += nodes[level];
    }
  }
  search_kernel_.launch(round_up(set.count, kLocalSize),
                        kLocalSize,
                        set.params,
                        set.stride,
                        set.count,
                        set.actors,
                        set.actor_of,
                        n,
                        targets.actors,
                        targets.actor_of,
                        reach_m * reach_m,
                        boxes_,
                        points_,
                        ids_,
                        candidates_,
                        nearest_);
}

bool AnchorStage::is_assigned_for(const ParticleBuffers& set) const { return nearest_.count() == set.count; }

void AnchorStage::add_gradient(const ParticleBuffers& set,
                               const ParticleBuffers& targets,
                               const Buffer<std::uint32_t>& keys,
                               double weight,
                               bool choose,
                               RealBuffer& grads) {
  const Chunks chunks = chunks_of(device_, set.count);
  sums_.reserve(2 * chunks.work_items);
  loss_kernel_.launch(chunks.work_items,
                      1,
                      set.count,
                      chunks.chunk,
                      keys,
                      set.params,
                      set.stride,
                      set.actors,
                      set.actor_of,
                      targets.params,
                      targets.stride,
                      targets.actors,
                      targets.actor_of,
                      candidates_,
                      choose ? 1U : 0U,
                      weight,
                      nearest_,
                      grads,
                      sums_);
}

AnchorLoss AnchorStage::loss() const {
  AnchorLoss total;
  const std::vector<double> parts = sums_.download_double();
  for (std::size_t i = 0; i < parts.size(); i += 2) {
    total.distance_m += parts[i];
    total.particles += parts[i + 1];
  }
  return total;
}

}  // namespace simuli
