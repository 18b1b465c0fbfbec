#include "optim/train/chunk/chunk_scene.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/core/scene/occluders.hpp"
#include "host/core/scene/particle_order.hpp"

namespace simuli {
namespace {

constexpr double kVisibilityStep_m = 5.0;  // spacing of the path positions stored for a chunk
constexpr double kNear_m = 100.0;  // path beyond a chunk within which an actor may still occlude part of it

std::uint32_t actor_of(const GaussianSet& set, Eigen::Index i) {
  return set.actor.empty() ? 0U : set.actor[static_cast<std::size_t>(i)];
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation.w() < 0.0 ? Eigen::Quaterniond(-rotation.coeffs()) : rotation);
  return turn.angle() * turn.axis();
}

/// Returns the pose of the actor's frame in one chunk relative to its frame in another chunk: the mean over key
/// poses at times that both chunks saw. An error common to all key poses of a chunk is not observable.
Pose common(const Actor& of, const Actor& in, const DrivenPath& path, const DriveChunk& both) {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t k = 0; k < of.track.size(); ++k) {
    const double position_m = path.place_at(of.track[k].time_s);
    if (position_m < both.from_m || position_m > both.to_m) continue;
    const Pose apart = in.track[k].corrected().inverse() * of.track[k].corrected();
    shift += apart.translation;
    turn += rotation_vector(apart.rotation);
    ++count;
  }
  if (count == 0.0) return {};
  const double angle = turn.norm() / count;
  const Eigen::Vector3d axis = angle > 0.0 ? Eigen::Vector3d(turn.normalized()) : Eigen::Vector3d::UnitZ();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), shift / count};
}

/// Moves the key pose to this actor pose.
void correct(KeyPose& key, const Pose& world_from_actor) {
  key.shift_m = world_from_actor.translation - key.world_from_actor.translation;
  const Eigen::Quaterniond turn = world_from_actor.rotation * key.world_from_actor.rotation.conjugate();
  key.turn_rad = rotation_vector(turn);
}

/// Counts that decide which particles of a chunk are kept: particles by owner number, 0 for the background.
struct PartCounts {
  OwnerNumbers numbers;
  std::vector<Actor> actors;
  std::vector<std::string> occluders;  // names of the occluders
  std::vector<Eigen::Index> camera, lidar;
};

/// One actor as seen by all chunks.
class ActorParts {
 public:
  ActorParts(const std::vector<PartCounts>& parts, const std::string& name) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::vector<Actor>& actors = parts[i].actors;
      const auto found =
          std::find_if(actors.begin(), actors.end(), [&](const Actor& a) { return a.name == name; });
      if (found == actors.end()) continue;
      const std::uint32_t number = parts[i].numbers.actor(static_cast<std::size_t>(found - actors.begin()));
      const Eigen::Index particles = parts[i].camera[number] + parts[i].lidar[number];
      seen_[i] = {&*found, number};
      if (particles <= most_) continue;
      most_ = particles;
      owner_ = i;
    }
  }
  [[nodiscard]] bool has_particles() const { return most_ > 0; }
  [[nodiscard]] std::size_t owner() const { return owner_; }
  [[nodiscard]] std::uint32_t number() const { return seen_.at(owner_).number; }
  /// Deformation of the owning chunk, whose particles it moves; beyond that chunk's part of the path the shape
  /// is constant.
  [[nodiscard]] const Deformation& deformation() const { return seen_.at(owner_).actor->deformation; }

  /// Track of the owning chunk, continued beyond its part of the path by the tracks of the other chunks in the
  /// owner's frame.
  [[nodiscard]] std::vector<KeyPose> track(const ChunkSplit& parting) const {
    const Actor& own = *seen_.at(owner_).actor;
    std::map<std::size_t, Pose> theirs_from_own;
    theirs_from_own[owner_] = {};
    const auto chain = [&](std::size_t from, std::size_t to) {
      if (!seen_.contains(to)) return;
      const double border_m = parting.chunks[std::max(from, to)].from_m;
      const DriveChunk shared{border_m - parting.overlap_m, border_m + parting.overlap_m};
      const auto known = theirs_from_own.find(from);
      const Pose so_far = known == theirs_from_own.end() ? Pose{} : known->second;
      const bool both = seen_.contains(from);
      theirs_from_own[to] =
          both ? common(*seen_.at(from).actor, *seen_.at(to).actor, parting.path, shared) * so_far : Pose{};
    };
    for (std::size_t i = owner_ + 1; i < parting.chunks.size(); ++i) chain(i - 1, i);
    for (std::size_t i = owner_; i > 0; --i) chain(i, i - 1);
    std::vector<KeyPose> track = own.track;
    for (std::size_t k = 0; k < track.size(); ++k) {
      const std::size_t at = chunk_at(parting.chunks, parting.path.place_at(track[k].time_s));
      const auto seen = seen_.find(at);
      if (at == owner_ || seen == seen_.end()) continue;
      correct(track[k], seen->second.actor->track[k].corrected() * theirs_from_own.at(at));
    }
    return track;
  }

 private:
  struct Seen {
    const Actor* actor = nullptr;
    std::uint32_t number = 0;  // owner number of its particles
  };
  std::map<std::size_t, Seen> seen_;  // by chunk
  std::size_t owner_ = 0;
  Eigen::Index most_ = 0;
};

std::vector<Eigen::Index> counts_of(const GaussianSet& set, std::size_t owners) {
  std::vector<Eigen::Index> counts(owners + 1, 0);
  for (Eigen::Index i = 0; i < set.size(); ++i) ++counts[actor_of(set, i)];
  return counts;
}

/// A Gaussian set of known size that is filled from the front.
class FilledSet {
 public:
  FilledSet(GaussianSet& set, Eigen::Index count) : set_(set) {
    set.params.resize(count, param_rows(set.sh_degree));
    set.actor.reserve(static_cast<std::size_t>(count));
  }
  /// Appends the particles whose owner number (GaussianSet::actor) is a key of `numbers`, under the mapped
  /// number.
  void add(const GaussianSet& from, const std::map<std::uint32_t, std::uint32_t>& numbers) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < from.size(); ++i) {
      const auto number = numbers.find(actor_of(from, i));
      if (number == numbers.end()) continue;
      kept.push_back(i);
      set_.actor.push_back(number->second);
    }
    set_.params.middleRows(end_, static_cast<Eigen::Index>(kept.size())) = from.params(kept, Eigen::all);
    end_ += static_cast<Eigen::Index>(kept.size());
  }

 private:
  GaussianSet& set_;
  Eigen::Index end_ = 0;
};

/// Returns the actor with the part of its track recorded near the chunk.
Actor occluder_of(const ChunkSplit& parting, std::size_t index, Actor actor) {
  const DriveChunk& chunk = parting.chunks[index];
  std::vector<KeyPose> near;
  for (const KeyPose& key : actor.track) {
    const double position_m = parting.path.place_at(key.time_s);
    if (position_m >= chunk.from_m - kNear_m && position_m <= chunk.to_m + kNear_m) near.push_back(key);
  }
  if (!near.empty()) actor.track = std::move(near);
  actor.deformation = {};
  return actor;
}

void add_mean(std::vector<double>& sum, const std::vector<float>& values) {
  sum.resize(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sum[i] += static_cast<double>(values[i]);
}

}  // namespace

void add_chunk(TrainReport& all, const TrainReport& own, double share) {
  all.last.psnr_db += share * own.last.psnr_db;
  all.last.distance_m += share * own.last.distance_m;
  all.last.drop_accuracy += share * own.last.drop_accuracy;
  all.relocated += own.relocated;
  all.grown += own.grown;
  all.pruned += own.pruned;
  all.row_ranges_m = std::max(all.row_ranges_m, own.row_ranges_m);
  all.anchor_m += share * own.anchor_m;
  all.rejected_gradients += own.rejected_gradients;
  all.unsound_particles += own.unsound_particles;
  all.unsound_losses += own.unsound_losses;
  all.stopped_early = all.stopped_early || own.stopped_early;
  all.seconds += own.seconds;
  all.ranks = own.ranks;
  all.gathered_bytes += own.gathered_bytes;
  all.warnings.insert(all.warnings.end(), own.warnings.begin(), own.warnings.end());
}

Scene owned(Scene scene, const ChunkSplit& parting, std::size_t index) {
  const OwnerNumbers numbers = owner_numbers(scene);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < scene.lidar.size(); ++i) {
    const bool is_actors = numbers.is_actor(actor_of(scene.lidar, i));
    const auto is_own = [&] {
      const Eigen::Vector3f mean = scene.lidar.mean().row(i);
      return chunk_at(parting.chunks, parting.path.place_nearest(mean)) == index;
    };
    if (is_actors || is_own()) kept.push_back(i);
  }
  scene.lidar = subset(scene.lidar, kept);
  return scene;
}

void MeanRayDrop::add(const ChunkScene& part) {
  const double weight = std::max(static_cast<double>(part.report.sweeps), 1.0);
  for (const RayDrop& drop : part.scene.ray_drop) {
    Sum& sum = sums_[drop.lidar];
    for (std::size_t k = 0; k < drop.parameters.size(); ++k) {
      sum.parameters[k] += weight * drop.parameters[k];
    }
    sum.weight += weight;
  }
}

std::vector<RayDrop> MeanRayDrop::mean() const {
  std::vector<RayDrop> out;
  for (const auto& [lidar, sum] : sums_) {
    RayDrop& drop = out.emplace_back(RayDrop{lidar, sum.parameters});
    for (double& value : drop.parameters) value /= sum.weight;
  }
  return out;
}

Scene merged(std::size_t count,
             const ChunkReader& part,
             const std::vector<Actor>& actors,
             const ChunkSplit& parting) {
  Scene out;
  std::vector<PartCounts> parts;
  std::vector<double> texels, background;
  MeanRayDrop ray_drop;
  for (std::size_t i = 0; i < count; ++i) {
    const ChunkScene& chunk = part(i);
    const Scene& own = chunk.scene;
    if (i == 0) {
      out.name = own.name;
      out.origin = own.origin;
      out.lidar_background = own.lidar_background;
      out.environment = own.environment;
      out.camera = GaussianSet(SetKind::kCamera, own.camera.sh_degree, 0);
      out.lidar = GaussianSet(SetKind::kLidar, own.lidar.sh_degree, 0);
    }
    PartCounts& counted = parts.emplace_back();
    counted.numbers = owner_numbers(own);
    const std::size_t owners = counted.numbers.largest();
    counted.actors = own.actors;
    for (const Actor& occluder : own.occluders) counted.occluders.push_back(occluder.name);
    counted.camera = counts_of(own.camera, owners);
    counted.lidar = counts_of(own.lidar, owners);
    ray_drop.add(chunk);
    add_mean(texels, own.environment.texels);
    add_mean(background, {own.camera_background.begin(), own.camera_background.end()});
  }
  for (std::size_t i = 0; i < texels.size(); ++i) {
    out.environment.texels[i] = static_cast<float>(texels[i] / static_cast<double>(count));
  }
  for (std::size_t c = 0; c < background.size(); ++c) {
    out.camera_background[c] = static_cast<float>(background[c] / static_cast<double>(count));
  }
  out.ray_drop = ray_drop.mean();

  std::vector<std::map<std::uint32_t, std::uint32_t>> numbers(count, {{0U, 0U}});  // by chunk: new number by old number
  Eigen::Index camera_count = 0, lidar_count = 0;
  const auto keep = [&](std::size_t chunk, std::uint32_t number) {
    camera_count += parts[chunk].camera[number];
    lidar_count += parts[chunk].lidar[number];
  };
  for (std::size_t i = 0; i < count; ++i) keep(i, 0);
  for (const Actor& actor : actors) {
    const ActorParts of_actor(parts, actor.name);
    Actor& merged_actor = out.actors.emplace_back(actor);
    if (!of_actor.has_particles()) continue;
    merged_actor.track = of_actor.track(parting);
    merged_actor.deformation = of_actor.deformation();
    numbers[of_actor.owner()][of_actor.number()] = static_cast<std::uint32_t>(out.actors.size());
    keep(of_actor.owner(), of_actor.number());
  }

  for (std::size_t i = 0; i < count; ++i) {
    VisibilitySet& visibility_set = out.visibility_sets.emplace_back();
    visibility_set.path_m = parting.path.places_of(parting.chunks[i], kVisibilityStep_m);
    for (Eigen::Vector3d& place : visibility_set.path_m) place += out.origin;
    for (const std::string& name : parts[i].occluders)
      visibility_set.occluders.push_back(occluder_of(parting, i, out.actors[find_actor(out.actors, name)]));
  }
  std::size_t occluder = 0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < parts[i].occluders.size(); ++k, ++occluder) {
      const std::uint32_t behind = parts[i].numbers.disoccluded(k), instead = parts[i].numbers.inpainted(k);
      numbers[i][behind] = disoccluded_number(out, occluder);
      numbers[i][instead] = inpainted_number(out, occluder);
      keep(i, behind);
      keep(i, instead);
    }
  }
  FilledSet camera(out.camera, camera_count), lidar(out.lidar, lidar_count);
  for (std::size_t i = 0; i < count; ++i) {
    const Scene& own = part(i).scene;
    lidar.add(own.lidar, numbers[i]);
    numbers[i][0] = number_of_visibility_set(out, i);
    camera.add(own.camera, numbers[i]);
  }
  return in_coherent_order(std::move(out));
}

}  // namespace simuli
