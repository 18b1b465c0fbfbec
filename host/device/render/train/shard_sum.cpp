// Launcher of "kernels/shard_sum.cl".
#include "host/device/render/train/shard_sum.hpp"

#include <algorithm>
#include <bit>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/render/options/lane_shape.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kCulled = 0xffffffffU;

Program program(const Device& device, Precision precision) {
  return {device, "kernels/shard_sum.cl", lane_options(device, precision)};
}

void need_count(const char* what, std::size_t found, std::size_t allowed) {
  if (found == allowed) return;
  throw Error(ErrorKind::kInternal, fmt::format("{}: found {} numbers, allowed {}", what, found, allowed));
}

std::size_t groups(std::size_t count, int lanes) {
  const auto size = static_cast<std::size_t>(lanes);
  return (count + size - 1) / size;
}

}  // namespace

ShardSum::ShardSum(const Device& device, Precision precision)
    : lanes_(lane_shape_of(device, precision).lanes),
      buffers_(device, precision),
      add_(program(device, precision), "add_rendered"),
      pack_(program(device, precision), "pack_columns"),
      add_packed_(program(device, precision), "add_packed"),
      add_row_(program(device, precision), "add_row"),
      add_all_(program(device, precision), "add_all") {}

std::size_t ShardSum::most_nodes(std::size_t shards) {
  return static_cast<std::size_t>(std::bit_width(std::max<std::size_t>(shards, 2) - 1)) + 1;
}

void ShardSum::start(const ParticleBuffers& particles, bool errors) {
  particles_ = particles.count;
  stride_ = particles.stride;
  rows_ = particles.params.count() / stride_ + (errors ? 1 : 0);
  errors_ = errors;
  nodes_.clear();
  free_.clear();
  for (std::size_t place = pool_.size(); place > 0; --place) free_.push_back(place - 1);
}

RealBuffer& ShardSum::fresh_errors() {
  buffers_.errors.reserve(stride_);
  buffers_.errors.fill(0.0);
  return buffers_.errors;
}

void ShardSum::add(std::size_t shard,
                   const Buffer<std::uint32_t>& keys,
                   const RealBuffer& grads,
                   double share) {
  const std::size_t rows = rows_ - (errors_ ? 1 : 0);
  need_count("gradients of a shard", grads.count(), rows * stride_);
  // The second half of a pair needs no buffer of its own: it is rounded before it is added.
  const bool is_second =
      !nodes_.empty() && nodes_.back().size == 1 && shard % 2 == 1 && nodes_.back().first + 1 == shard;
  const std::size_t place = is_second ? nodes_.back().place : free_place();
  if (errors_) add_to(place, keys, buffers_.errors, 1, rows, false, 1.0);
  add_to(place, keys, grads, rows, 0, true, share);
  if (!is_second) return push({shard, 1, place});
  const Node pair{shard - 1, 2, place};
  nodes_.pop_back();
  push(pair);
}

std::vector<std::uint32_t> ShardSum::columns_of(std::size_t node) const {
  const std::vector<std::uint32_t> keys = pool_[nodes_.at(node).place]->keys.download();
  std::vector<std::uint32_t> columns;
  columns.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] != kCulled) columns.push_back(static_cast<std::uint32_t>(i));
  }
  return columns;
}

void ShardSum::pack(std::size_t node, std::span<const std::uint32_t> columns, std::span<float> target) {
  need_count("values of a shard", target.size(), rows_ * columns.size());
  buffers_.order.assign(columns);
  buffers_.packed.reserve(target.size());
  pack_.run_over(groups(columns.size(), lanes_),
                 {{"count", static_cast<std::uint32_t>(columns.size())},
                  {"rows", static_cast<std::uint32_t>(rows_)},
                  {"stride", static_cast<std::uint32_t>(stride_)},
                  {"order", buffers_.order},
                  {"sum", pool_[nodes_.at(node).place]->sum},
                  {"packed", buffers_.packed}});
  buffers_.packed.as_float().download(target);
}

void ShardSum::total(std::span<const Packed> others) {
  std::vector<Node> all = std::exchange(nodes_, {});
  for (const Packed& other : others) {
    need_count("values of a rank's shards", other.values.size(), rows_ * other.columns.size());
    if (!other.columns.empty() && other.columns.back() >= particles_) {
      need_count("particle of a rank's shards", other.columns.back(), particles_ - 1);
    }
    all.push_back({other.first, other.size, kElsewhere, &other});
  }
  std::sort(all.begin(), all.end(), [](const Node& a, const Node& b) { return a.first < b.first; });
  std::size_t next = 0;
  for (const Node& node : all) {
    need_count("first shard of a rank", node.first, next);
    next += node.size;
    push(node);
  }
  while (nodes_.size() > 1) join_last();
  Node& root = nodes_.at(0);
  if (root.packed == nullptr) return;
  root.place = free_place();
  add_to(root.place, *root.packed);
}

void ShardSum::add_errors(RealBuffer& sum) {
  need_count("errors of a set", sum.count(), particles_);
  add_row_.run_over(particles_,
                    {{"particles", static_cast<std::uint32_t>(particles_)},
                     {"stride", static_cast<std::uint32_t>(stride_)},
                     {"row", static_cast<std::uint32_t>(rows_ - 1)},
                     {"keys", keys()},
                     {"sums", sums()},
                     {"sum", sum}});
}

void ShardSum::add_all(std::span<const float> from, double share, RealBuffer& sum) {
  need_count("numbers of a shard", from.size(), sum.count());
  buffers_.packed.assign(from);
  add_all_.run_over(from.size(),
                    {{"count", static_cast<std::uint32_t>(from.size())},
                     {"share", share},
                     {"from", buffers_.packed},
                     {"sum", sum}});
}

/// Returns an empty sum from the pool.
std::size_t ShardSum::free_place() {
  if (free_.empty()) {
    free_.push_back(pool_.size());
    pool_.push_back(std::make_unique<ShardNodeBuffers>(buffers_.device(), buffers_.precision()));
  }
  const std::size_t place = free_.back();
  free_.pop_back();
  pool_[place]->sum.reserve(rows_ * stride_);
  pool_[place]->keys.reserve(particles_);
  pool_[place]->keys.fill(kCulled);
  return place;
}

void ShardSum::push(const Node& node) {
  nodes_.push_back(node);
  while (nodes_.size() > 1) {
    const Node& left = nodes_[nodes_.size() - 2];
    const Node& right = nodes_.back();
    if (left.size != right.size || left.first % (2 * left.size) != 0) return;
    if (left.first + left.size != right.first) return;
    join_last();
  }
}

/// Joins the last two nodes; the order of addition does not matter, because a + b = b + a.
void ShardSum::join_last() {
  const Node right = nodes_.back();
  nodes_.pop_back();
  Node& left = nodes_.back();
  if (left.packed != nullptr && right.packed == nullptr) {
    add_to(right.place, *left.packed);
    left.place = right.place;
  } else {
    if (left.packed != nullptr) {
      left.place = free_place();
      add_to(left.place, *left.packed);
    }
    if (right.packed != nullptr) {
      add_to(left.place, *right.packed);
    } else {
      const ShardNodeBuffers& from = *pool_[right.place];
      add_to(left.place, from.keys, from.sum, rows_, 0, true, 1.0);
      free_.push_back(right.place);
    }
  }
  left.packed = nullptr;
  left.size += right.size;
}

void ShardSum::add_to(std::size_t place,
                      const Buffer<std::uint32_t>& keys,
                      const RealBuffer& from,
                      std::size_t rows,
                      std::size_t first_row,
                      bool mark,
                      double share) {
  ShardNodeBuffers& to = *pool_[place];
  add_.run_over(groups(particles_, lanes_),
                {{"particles", static_cast<std::uint32_t>(particles_)},
                 {"stride", static_cast<std::uint32_t>(stride_)},
                 {"rows", static_cast<std::uint32_t>(rows)},
                 {"first", static_cast<std::uint32_t>(first_row)},
                 {"mark", mark ? 1U : 0U},
                 {"share", share},
                 {"from_keys", keys},
                 {"from", from},
                 {"keys", to.keys},
                 {"sum", to.sum}});
}

void ShardSum::add_to(std::size_t place, const Packed& packed) {
  ShardNodeBuffers& to = *pool_[place];
  buffers_.order.assign(packed.columns);
  buffers_.packed.assign(packed.values);
  add_packed_.run_over(groups(packed.columns.size(), lanes_),
                       {{"count", static_cast<std::uint32_t>(packed.columns.size())},
                        {"rows", static_cast<std::uint32_t>(rows_)},
                        {"stride", static_cast<std::uint32_t>(stride_)},
                        {"order", buffers_.order},
                        {"packed", buffers_.packed},
                        {"keys", to.keys},
                        {"sum", to.sum}});
}

}  // namespace simuli
