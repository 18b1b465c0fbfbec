// One iteration with several frames: each is a shard, computed as a whole by one rank. What all frames share
// (particles, environment) takes one step by the mean of their gradients, added in the order of shards; what
// belongs to one of them (grids, poses of actors at its time) a step for each, in that order.
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "optim/train/trainer.hpp"

namespace simuli {

/// What a shard's frame says of all that training moves but the particles, of which sum_ knows.
struct Trainer::ShardPart {
  std::vector<double> losses;  // as Trainer's note_*() take them
  std::vector<double> actors;  // 12 for each, where their poses are learned
  std::vector<double> shapes;  // of those that have one, as numbers_of() has them
  std::vector<float> grid, environment;
  std::vector<TrainedDrop::Function> drop;  // what a sweep teaches; one, or none

  void put(RankWriter& writer) const {
    visit(*this, [&writer](const auto& values) { writer.put(values); });
  }
  [[nodiscard]] static ShardPart of(RankReader& reader) {
    ShardPart part;
    visit(part, [&reader](auto& values) { reader.get(values); });
    return part;
  }

 private:
  template <class Part, class F>
  static void visit(Part& p, F&& f) {
    f(p.losses), f(p.actors), f(p.shapes), f(p.grid), f(p.environment), f(p.drop);
  }
};

namespace {

constexpr std::size_t kActorNumbers = 12;

std::vector<double> numbers_of(const std::vector<ActorPoseGradient>& actors) {
  std::vector<double> out;
  for (const ActorPoseGradient& actor : actors) {
    for (const auto* part : {&actor.shift_start, &actor.turn_start, &actor.shift_end, &actor.turn_end}) {
      out.insert(out.end(), part->begin(), part->end());
    }
  }
  return out;
}

std::vector<ActorPoseGradient> actors_of(const std::vector<double>& numbers) {
  std::vector<ActorPoseGradient> out(numbers.size() / kActorNumbers);
  const double* from = numbers.data();
  for (ActorPoseGradient& actor : out) {
    for (auto* part : {&actor.shift_start, &actor.turn_start, &actor.shift_end, &actor.turn_end}) {
      *part = Eigen::Vector3d(from);
      from += 3;
    }
  }
  return out;
}

/// Of each actor how many numbers its shape has, then these at the frame's start and end.
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

std::vector<std::size_t> Trainer::shard_frames(FrameOrder& order, int turn) const {
  const auto count = static_cast<std::uint64_t>(options_.shards.count);
  std::vector<std::size_t> frames;
  for (std::uint64_t s = 0; s < count; ++s) {
    frames.push_back(order.at(static_cast<std::uint64_t>(turn) * count + s));
  }
  return frames;
}

std::vector<Trainer::ShardPart> Trainer::run_shards(TrainedSet& set, bool errors, const ShardFrame& frame) {
  // Neighbours are of one rank, so that what it sends is few sums of several.
  const auto count = static_cast<std::size_t>(options_.shards.count);
  const auto begin = [&](std::size_t rank) { return rank * count / ranks_.size(); };
  sum_->start(set.particles, errors);
  std::vector<ShardPart> parts;
  for (std::size_t shard = begin(ranks_.rank()); shard < begin(ranks_.rank() + 1); ++shard) {
    parts.push_back(frame(shard));
  }
  if (ranks_.size() == 1) {
    sum_->total({});
  } else {
    parts = gather_shards(parts);
  }
  if (errors) sum_->add_errors(set.error);
  return parts;
}

std::vector<Trainer::ShardPart> Trainer::gather_shards(const std::vector<ShardPart>& own) {
  RankWriter writer(std::move(message_));
  writer.put(std::vector<std::uint64_t>{sum_->nodes(), own.size()});
  // Sums first: what stands in front of them has whole multiples of their numbers' sizes.
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

void Trainer::add_shard(std::size_t shard, const TrainedSet& set, const Pass& pass) {
  sum_->add(shard, pass.buffers().projected.keys, set.grads, 1.0 / options_.shards.count);
}

Trainer::ShardPart Trainer::part_of(const Turn& turn, Shown& shown, std::size_t shard) {
  ShardPart part;
  part.losses = std::move(shown.losses);
  RealBuffer& error = turn.errors ? sum_->fresh_errors() : turn.set.error;
  differentiate(turn, shown.pass, error);
  if (turn.set.particles.actors > 0 && turn.set.poses.learns()) {
    part.actors = numbers_of(shown.pass.pose_gradients(turn.set.particles));
  }
  if (turn.set.particles.actors > 0 && turn.set.shapes.learns())
    part.shapes = numbers_of(shown.pass.deformation_gradients());
  add_shard(shard, turn.set, shown.pass);
  return part;
}

void Trainer::descend_shards(const Turn& turn,
                             const std::vector<ShardPart>& parts,
                             const std::vector<FrameTimes>& frames) {
  TrainedSet& set = turn.set;
  if (turn.number == kCameraSet) structure_.settle_anchors(sum_->keys(), status_.iteration);
  take_step(turn, sum_->sums(), sum_->keys());
  structure_.jitter(set, turn.number, turn.rates, sum_->keys(), status_.iteration, turn.progress);
  if (set.particles.actors == 0) return;
  renderer_.confine(set.particles, scene_.actors, options_.actor_margin_m);
  for (std::size_t i = 0; i < parts.size() && set.poses.learns(); ++i) {
    set.poses.step(
        scene_.actors, actors_of(parts[i].actors), frames[i].start_s, frames[i].end_s, turn.progress);
  }
  for (std::size_t i = 0; i < parts.size() && set.shapes.learns(); ++i) {
    set.shapes.step(
        scene_.actors, shapes_of(parts[i].shapes), frames[i].start_s, frames[i].end_s, turn.progress);
  }
}

void Trainer::step_camera_shards(double progress) {
  const std::vector<std::size_t> indices = shard_frames(images_, status_.iteration);
  std::vector<FrameTimes> frames;
  for (const std::size_t index : indices) {
    const ImageFrame& frame = log_.images[index];
    frames.push_back({frame.camera, frame.time_start_s, frame.time_end_s});
  }
  const Turn turn = camera_turn(progress);
  const auto parts = run_shards(camera_, turn.errors, [&](std::size_t shard) {
    Shown shown = show_picture(turn, indices[shard]);
    TrainedLook::Gradients look = look_.gradients();
    ShardPart part = part_of(turn, shown, shard);
    part.grid = std::move(look.grid);
    part.environment = std::move(look.environment);
    return part;
  });
  std::vector<TrainedLook::Shard> looks;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    looks.push_back({indices[i], {parts[i].grid, parts[i].environment}});
  }
  look_.step(looks, static_cast<std::uint64_t>(status_.iteration), progress, *sum_);
  descend_shards(turn, parts, frames);
  for (std::size_t i = 0; i < parts.size(); ++i) note_picture(indices[i], parts[i].losses);
}

void Trainer::step_depth_shards(double progress) {
  const auto indices = shard_frames(sweeps_, status_.iteration / options_.depth.every);
  descend_shards(progress, [&](std::size_t shard) { return show_depth(indices[shard]); });
}

void Trainer::step_beside_shards(double progress) {
  const std::vector<std::size_t> indices = shard_frames(images_, status_.iteration);
  const std::uint64_t first = static_cast<std::uint64_t>(status_.iteration) * indices.size();
  descend_shards(progress, [&](std::size_t shard) { return show_beside(indices[shard], first + shard); });
}

void Trainer::descend_shards(double progress, const std::function<Shown(std::size_t)>& show) {
  const auto parts = run_shards(camera_, false, [&](std::size_t shard) {
    Shown shown = show(shard);
    add_shard(shard, camera_, shown.pass);
    ShardPart part;
    part.losses = std::move(shown.losses);
    return part;
  });
  take_step(camera_turn(progress), sum_->sums(), sum_->keys());
  for (const ShardPart& part : parts) static_cast<void>(is_sound(part.losses[0]));
}

void Trainer::step_lidar_shards(double progress) {
  const auto indices = shard_frames(sweeps_, status_.iteration / options_.lidar_every);
  std::vector<FrameTimes> frames;
  for (const std::size_t index : indices) {
    const SweepFrame& frame = log_.sweeps[index];
    frames.push_back({frame.lidar, frame.time_start_s, frame.time_end_s});
  }
  const Turn turn = lidar_turn(progress);
  const auto parts = run_shards(lidar_, turn.errors, [&](std::size_t shard) {
    std::vector<TrainedDrop::Function> taught;
    Shown shown = show_sweep(turn, indices[shard], &taught);
    ShardPart part = part_of(turn, shown, shard);
    part.drop = std::move(taught);
    return part;
  });
  std::map<std::string, std::vector<TrainedDrop::Function>> taught;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto& functions = taught[frames[i].sensor];
    functions.insert(functions.end(), parts[i].drop.begin(), parts[i].drop.end());
  }
  for (const auto& [lidar, functions] : taught) drop_.take(lidar, functions);
  descend_shards(turn, parts, frames);
  for (std::size_t i = 0; i < parts.size(); ++i) note_sweep(indices[i], parts[i].losses);
}

}  // namespace simuli
