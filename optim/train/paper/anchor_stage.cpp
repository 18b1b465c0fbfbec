// Launcher of "paper/anchor.cl".
#include "optim/train/paper/anchor_stage.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace simuli {
namespace {

constexpr std::uint64_t kWidth = AnchorSizes::kWidth;
constexpr double kCells = 2097152.0;  // per axis: 21 bits

Program program(const Device& device, Precision precision, std::uint32_t neighbours, std::size_t work_items) {
  BuildOptions options;
  options.real(precision).define("NEIGHBOURS", neighbours).define("LS", work_items);
  return {device, "paper/anchor.cl", options};
}

std::size_t work_items_of(const Device& device, std::size_t requested) {
  if (requested != 0) return requested;
  return device.info().is_cpu ? 1 : std::size_t{kWidth};
}

}  // namespace

std::vector<std::uint64_t> AnchorSizes::levels() const {
  std::vector<std::uint64_t> nodes;
  if (targets == 0) return nodes;
  for (std::uint64_t below = leaves(); nodes.empty() || below > 1; below = nodes.back()) {
    nodes.push_back((below + kWidth - 1) / kWidth);
  }
  return nodes;
}

std::uint64_t AnchorSizes::nodes() const {
  const std::vector<std::uint64_t> all = levels();
  return std::accumulate(all.begin(), all.end(), std::uint64_t{0});
}

AnchorStage::AnchorStage(const Device& device,
                         Precision precision,
                         std::uint32_t neighbours,
                         std::size_t work_items)
    : device_(device),
      work_items_(work_items_of(device, work_items)),
      neighbours_(neighbours),
      sort_(device),
      buffers_(device, precision),
      bounds_(program(device, precision, neighbours, work_items_), "anchor_bounds"),
      keys_(program(device, precision, neighbours, work_items_), "anchor_keys"),
      leaves_(program(device, precision, neighbours, work_items_), "anchor_leaves"),
      nodes_(program(device, precision, neighbours, work_items_), "anchor_nodes"),
      search_(program(device, precision, neighbours, work_items_), "anchor_search"),
      loss_(program(device, precision, neighbours, work_items_), "anchor_loss") {}

AnchorSizes AnchorStage::sizes() const {
  return {particles_,
          neighbours_,
          targets_,
          targets_ > 0 ? chunks_of(device_, targets_).work_items : 0,
          chunks_of(device_, particles_).work_items};
}

void AnchorStage::assign(const ParticleBuffers& set, const ParticleBuffers& targets, double reach_m) {
  particles_ = set.count;
  targets_ = targets.count;
  buffers_.reserve(sizes());
  if (targets_ > 0) build_tree(targets);
  const std::initializer_list<Binding> bindings{{"queries", set.params},
                                                {"query_stride", set.stride},
                                                {"query_count", set.count},
                                                {"query_actors", set.actors},
                                                {"query_actor_of", set.actor_of},
                                                {"n", targets_},
                                                {"actors", targets.actors},
                                                {"actor_of", targets.actor_of},
                                                {"reach2", reach_m * reach_m},
                                                buffers_};
  if (work_items_ == 1)
    search_.run_over(set.count, bindings);
  else
    search_.run(set.count * work_items_, work_items_, bindings);
}

void AnchorStage::build_tree(const ParticleBuffers& targets) {
  order_by_place(targets);
  box_leaves(targets);
  const std::vector<std::uint64_t> levels = sizes().levels();
  std::uint64_t first = 0;
  for (std::size_t level = 0; level + 1 < levels.size(); ++level) {
    nodes_.run_over(levels[level],
                    {{"boxes", buffers_.boxes},
                     {"child_first", static_cast<std::uint32_t>(first)},
                     {"children", static_cast<std::uint32_t>(levels[level])},
                     {"parent_first", static_cast<std::uint32_t>(first + levels[level])}});
    first += levels[level];
  }
}

void AnchorStage::order_by_place(const ParticleBuffers& targets) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::uint32_t n = targets.count;
  const Chunks chunks = chunks_of(device_, n);
  bounds_.run(
      chunks.work_items,
      chunks.group,
      {targets, {"stride", targets.stride}, {"n", n}, {"chunk", chunks.chunk}, {"boxes", buffers_.parts}});
  const std::vector<double> parts = buffers_.parts.download_double();
  double low[3] = {kInfinity, kInfinity, kInfinity};
  double side = 0.0;
  for (std::size_t i = 0; i < parts.size(); i += 6) {
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], parts[i + k]);
  }
  for (std::size_t i = 0; i < parts.size(); i += 6) {
    for (std::size_t k = 0; k < 3; ++k) side = std::max(side, parts[i + 3 + k] - low[k]);
  }
  // Points at a single position, or no points: any cell size works.
  const double cells_per_m = side > 0.0 ? kCells / side : 1.0;
  buffers_.frame.assign(std::vector<double>{low[0], low[1], low[2], cells_per_m});
  for (const std::uint32_t shift : {0U, 32U}) {
    keys_.run_over(n,
                   {targets,
                    {"stride", targets.stride},
                    {"n", n},
                    {"frame", buffers_.frame},
                    {"shift", shift},
                    {"order", buffers_.order},
                    {"keys", buffers_.keys}});
    sort_.run(buffers_.keys, buffers_.order, n, 32);
  }
}

void AnchorStage::box_leaves(const ParticleBuffers& targets) {
  const std::uint64_t leaves = sizes().leaves();
  buffers_.boxes.fill(std::numeric_limits<double>::quiet_NaN());
  leaves_.run_over(leaves,
                   {targets,
                    {"stride", targets.stride},
                    {"n", targets.count},
                    {"order", buffers_.order},
                    buffers_,
                    {"leaves", static_cast<std::uint32_t>(leaves)}});
}

bool AnchorStage::is_assigned_for(const ParticleBuffers& set) const {
  return buffers_.nearest.count() == set.count;
}

void AnchorStage::add_gradient(const ParticleBuffers& set,
                               const ParticleBuffers& targets,
                               const Buffer<std::uint32_t>& keys,
                               double weight,
                               bool choose,
                               RealBuffer& grads) {
  const Chunks chunks = chunks_of(device_, set.count);
  buffers_.sums.reserve(2 * chunks.work_items);
  loss_.run(chunks.work_items,
            chunks.group,
            {{"n", set.count},
             {"chunk", chunks.chunk},
             {"keys", keys},
             set,
             {"stride", set.stride},
             {"actors", set.actors},
             {"targets", targets.params},
             {"target_stride", targets.stride},
             {"target_actors", targets.actors},
             {"target_actor_of", targets.actor_of},
             buffers_,
             {"choose", choose ? 1U : 0U},
             {"weight", weight},
             {"grads", grads},
             {"sums", buffers_.sums}});
}

void AnchorStage::follow_set(const std::vector<Eigen::Index>& order) {
  const auto move = [&order](Buffer<std::uint32_t>& words, std::size_t width) {
    const std::vector<std::uint32_t> before = words.download();
    std::vector<std::uint32_t> after = before;
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::copy_n(
          before.begin() + order[i] * static_cast<std::ptrdiff_t>(width), width, after.begin() + i * width);
    }
    words.assign(after);
  };
  move(candidates(), neighbours_);
  move(nearest(), 1);
}

void AnchorStage::follow_targets(const std::vector<Eigen::Index>& order) {
  std::vector<std::uint32_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[static_cast<std::size_t>(order[i])] = static_cast<std::uint32_t>(i);
  }
  for (Buffer<std::uint32_t>* const words : {&candidates(), &nearest()}) {
    std::vector<std::uint32_t> targets = words->download();
    for (std::uint32_t& target : targets) {
      if (target < place.size()) target = place[target];  // otherwise the list has ended
    }
    words->assign(targets);
  }
}

AnchorLoss AnchorStage::loss() const {
  AnchorLoss total;
  const std::vector<double> parts = buffers_.sums.download_double();
  for (std::size_t i = 0; i < parts.size(); i += 2) {
    total.distance_m += parts[i];
    total.particles += parts[i + 1];
  }
  return total;
}

}  // namespace simuli
