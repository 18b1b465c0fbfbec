#include "optim/train/shards.hpp"

#include <Eigen/Core>
#include <span>
#include <utility>

namespace simuli {
namespace {

constexpr std::size_t kPoseNumbers = 12;

std::vector<double> numbers_of(const std::vector<ActorPoseGradient>& actors) {
  std::vector<double> out;
  for (const ActorPoseGradient& actor : actors) {
    for (const auto* part : {&actor.shift_start, &actor.revolution_start, &actor.shift_end, &actor.turn_end}) {
      out.insert(out.end(), part->begin(), part->end());
    }
  }
  return out;
}

std::vector<ActorPoseGradient> poses_of(const std::vector<double>& numbers) {
  std::vector<ActorPoseGradient> out(numbers.size() / kPoseNumbers);
  const double* from = numbers.data();
  for (ActorPoseGradient& actor : out) {
    for (auto* part : {&actor.shift_start, &actor.revolution_start, &actor.shift_end, &actor.turn_end}) {
      *part = Eigen::Vector3d(from);
      from += 3;
    }
  }
  return out;
}

/// Serialises shape gradients: for each actor their number, then the values at the frame's start and end.
std::vector<double> numbers_of(const std::vector<DeformationGradient>& actors) {
  std::vector<double> out;
  for (const DeformationGradient& actor : actors) {
    out.push_back(static_cast<double>(actor.start.size()));
    out.insert(out.end(), actor.start.begin(), actor.start.end());
    out.insert(out.end(), actor.end.begin(), actor.end.end());
  }
  return out;
}

std::vector<DeformationGradient> shapes_of(const std::vector<double>& numbers) {
  std::vector<DeformationGradient> out;
  for (auto from = numbers.begin(); from != numbers.end();) {
    const auto count = static_cast<std::ptrdiff_t>(*from++);
    out.push_back({{from, from + count}, {from + count, from + 2 * count}});
    from += 2 * count;
  }
  return out;
}

}  // namespace

void ShardPart::put(RankWriter& writer) const {
  writer.put(losses);
  writer.put(numbers_of(poses));
  writer.put(numbers_of(shapes));
  writer.put(grid);
  writer.put(environment);
  writer.put(drop);
}

ShardPart ShardPart::of(RankReader& reader) {
  ShardPart part;
  std::vector<double> numbers;
  reader.get(part.losses);
  reader.get(numbers);
  part.poses = poses_of(numbers);
  reader.get(numbers);
  part.shapes = shapes_of(numbers);
  reader.get(part.grid);
  reader.get(part.environment);
  reader.get(part.drop);
  return part;
}

Shards::Shards(const Device& device, std::size_t count, Ranks& ranks) : count_(count), ranks_(ranks) {
  if (count > 1) sum_.emplace(device, Precision::kFloat);
}

std::vector<ShardPart> Shards::run(TrainedSet& set, bool errors, const Show& show) {
  std::vector<ShardPart> parts;
  if (!sum_) {
    RenderedShard shown = show(0, set.error);
    grads_ = &set.grads;
    keys_ = &shown.pass.buffers().projected.keys;
    parts.push_back(std::move(shown.part));
    return parts;
  }
  // Consecutive shards belong to one rank, so that a rank sends few partial sums.
  const auto begin = [&](std::size_t rank) { return rank * count_ / ranks_.size(); };
  sum_->start(set.particles, errors);
  for (std::size_t shard = begin(ranks_.rank()); shard < begin(ranks_.rank() + 1); ++shard) {
    RenderedShard shown = show(shard, errors ? sum_->fresh_errors() : set.error);
    sum_->add(shard, shown.pass.buffers().projected.keys, set.grads, 1.0 / static_cast<double>(count_));
    parts.push_back(std::move(shown.part));
  }
  if (ranks_.size() == 1) {
    sum_->total({});
  } else {
    parts = gather(parts);
  }
  if (errors) sum_->add_errors(set.error);
  grads_ = &sum_->sums();
  keys_ = &sum_->keys();
  return parts;
}

/// Gathers the parts of all ranks in the order of shards; sum_ then has the total.
std::vector<ShardPart> Shards::gather(const std::vector<ShardPart>& own) {
  RankWriter writer(std::move(message_));
  writer.put(std::vector<std::uint64_t>{sum_->nodes(), own.size()});
  // Sums come first, for alignment: their sizes are whole multiples of their values' size.
  for (std::size_t node = 0; node < sum_->nodes(); ++node) {
    const ShardSum::Packed shards = sum_->shards_of(node);
    const std::vector<std::uint32_t> columns = sum_->columns_of(node);
    writer.put(std::vector<std::uint64_t>{shards.first, shards.size});
    writer.put(columns);
    sum_->pack(node, columns, writer.room<float>(sum_->rows() * columns.size()));
  }
  for (const ShardPart& part : own) part.put(writer);
  message_ = writer.take();

  const std::span<const Ranks::Message> all = ranks_.all_gather(message_);
  std::vector<ShardPart> parts;
  std::vector<ShardSum::Packed> others;
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    gathered_bytes_ += all[rank].size();
    RankReader reader(all[rank]);
    std::vector<std::uint64_t> counts, shards;
    reader.get(counts);
    for (std::uint64_t node = 0; node < counts.at(0); ++node) {
      reader.get(shards);
      const auto columns = reader.view<std::uint32_t>();
      const auto values = reader.view<float>();
      if (rank != ranks_.rank()) others.push_back({shards.at(0), shards.at(1), columns, values});
    }
    for (std::uint64_t part = 0; part < counts.at(1); ++part) parts.push_back(ShardPart::of(reader));
  }
  sum_->total(others);
  return parts;
}

}  // namespace simuli
