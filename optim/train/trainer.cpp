#include "optim/train/trainer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/scene/particle_order.hpp"
#include "io/base/state_file.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/memory/memory.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kIterations = "iterations";  // planned
constexpr const char* kLength = "length";

enum Stream : std::uint64_t { kImageStream = 1, kSweepStream = 2 };

RenderOptions training_options(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

/// The particles' rates in steps of several frames.
TrainOptions with_rates_of_shards(TrainOptions o) {
  const double factor = std::pow(o.shards.count, o.shards.rate_power);
  for (LearningRates* const rates : {&o.camera, &o.lidar}) {
    for (double* const rate : {&rates->mean_m,
                               &rates->mean_final_m,
                               &rates->log_scale,
                               &rates->rotation,
                               &rates->opacity,
                               &rates->sh,
                               &rates->sh_rest}) {
      *rate *= factor;
    }
  }
  return o;
}

TrainOptions fitting(const Device& device,
                     const Log& log,
                     const Scene& scene,
                     const TrainingOptions& options) {
  static_cast<void>(checked(options));
  need_memory(device, log, scene, options);
  return with_rates_of_shards(options.train);
}

/// Iterations in which each training frame is looked at once.
std::size_t epoch_of(const TrainOptions& o, std::size_t images, std::size_t sweeps) {
  const std::size_t frames = images > 0 ? images : sweeps * static_cast<std::size_t>(o.lidar_every);
  const auto shards = static_cast<std::size_t>(o.shards.count);
  return (frames + shards - 1) / shards;
}

/// The particles all of whose parameters are finite, in their order.
GaussianSet finite_ones(const GaussianSet& set) {
  if (set.params.allFinite()) return set;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if (set.params.row(i).allFinite()) kept.push_back(i);
  }
  return subset(set, kept);
}

int planned_in(std::span<const std::byte> saved) {
  int planned = std::numeric_limits<int>::max();
  if (saved.size() == sizeof planned) std::memcpy(&planned, saved.data(), sizeof planned);
  return planned;
}

void need_iterations(const std::string& file, std::span<const std::byte> saved, const TrainOptions& options) {
  const int planned = planned_in(saved);
  const int iterations = options.length.automatic ? options.length.most : options.iterations;
  if (planned <= iterations) return;
  throw_input_error(file,
                    kIterations,
                    fmt::format("a training of {}", planned),
                    fmt::format("of {} or fewer: it can be made longer, not shorter", iterations));
}

void add_length(StateList& list, TrainLength& length) {
  list.add(
      kLength,
      [&length] {
        const std::vector<double> state = length.state();
        StateList::Bytes bytes(state.size() * sizeof(double));
        if (!bytes.empty()) std::memcpy(bytes.data(), state.data(), bytes.size());
        return bytes;
      },
      [&length](const std::string& file, std::span<const std::byte> saved) {
        std::vector<double> state(saved.size() / sizeof(double));
        if (!state.empty()) std::memcpy(state.data(), saved.data(), state.size() * sizeof(double));
        if (saved.size() % sizeof(double) == 0 && length.set_state(state)) return;
        throw_input_error(
            file, kLength, fmt::format("{} bytes", saved.size()), "a value per frame, whole stages");
      });
}

/// What has been found of the rows' ranges.
void add_range_biases(StateList& list, const Log& log, TruthCache& truth) {
  for (const LogLidar& lidar : log.lidars) {
    const auto* const rows = std::get_if<Lidar>(&lidar.model);
    if (rows == nullptr) continue;
    list.add_numbers(
        "range_biases/" + rows->name,
        [&truth, name = rows->name] {
          std::vector<double> out;
          for (const LidarRow& row : std::get<Lidar>(truth.lidar(name)).rows) out.push_back(row.range_bias);
          return out;
        },
        [&truth, name = rows->name](std::span<const double> numbers) {
          truth.set_range_biases(name, {numbers.begin(), numbers.end()});
        });
  }
}

/// m, largest difference of a row's range bias to the log's.
double largest_correction_m(const Log& log, const TruthCache& truth) {
  double largest_m = 0.0;
  for (const LogLidar& lidar : log.lidars) {
    const auto* const stated = std::get_if<Lidar>(&lidar.model);
    if (stated == nullptr) continue;
    const std::vector<LidarRow>& found = std::get<Lidar>(truth.lidar(stated->name)).rows;
    for (std::size_t row = 0; row < found.size(); ++row) {
      largest_m = std::max(largest_m, std::abs(found[row].range_bias - stated->rows[row].range_bias));
    }
  }
  return largest_m;
}

/// What has been learned of the actors' tracks.
void add_tracks(StateList& list, std::vector<Actor>& actors) {
  list.add_numbers(
      "actors/offsets",
      [&actors] {
        std::vector<double> out;
        for (const Actor& actor : actors) {
          for (const KeyPose& key : actor.track) {
            out.insert(out.end(), key.shift_m.begin(), key.shift_m.end());
            out.insert(out.end(), key.turn_rad.begin(), key.turn_rad.end());
          }
        }
        return out;
      },
      [&actors](std::span<const double> numbers) {
        for (Actor& actor : actors) {
          for (KeyPose& key : actor.track) {
            key.shift_m = Eigen::Vector3d(numbers.data());
            key.turn_rad = Eigen::Vector3d(numbers.data() + 3);
            numbers = numbers.subspan(6);
          }
        }
      });
}

/// What has been learned of their shapes.
void add_shapes(StateList& list, std::vector<Actor>& actors) {
  list.add_numbers(
      "actors/shapes",
      [&actors] {
        std::vector<double> out;
        for (const Actor& actor : actors) {
          const std::vector<double>& offsets = actor.deformation.offsets_m;
          out.insert(out.end(), offsets.begin(), offsets.end());
        }
        return out;
      },
      [&actors](std::span<const double> numbers) {
        for (Actor& actor : actors) {
          std::vector<double>& offsets = actor.deformation.offsets_m;
          std::copy_n(numbers.begin(), offsets.size(), offsets.begin());
          numbers = numbers.subspan(offsets.size());
        }
      });
}

}  // namespace

void RunningMean::add(double value) {
  constexpr double kKeep = 0.95;
  sum = kKeep * sum + value;
  weight = kKeep * weight + 1.0;
}

double RunningMean::value() const {
  return weight > 0.0 ? sum / weight : std::numeric_limits<double>::quiet_NaN();
}

Trainer::Trainer(
    const Device& device, const Log& log, Scene scene, const TrainingOptions& options, Ranks& ranks)
    : log_(log),
      ranks_(ranks),
      scene_(in_coherent_order(std::move(scene))),
      options_(fitting(device, log, scene_, options)),
      device_(device),
      renderer_(device, training_options(options_.render)),
      truth_(device, log, options, renderer_.options()),
      camera_(device, scene_.camera, options_.actor_poses, options_.actor_shapes),
      lidar_(device, scene_.lidar, options_.actor_poses, options_.actor_shapes),
      look_(device, log, scene_, options),
      drop_(log, scene_, options),
      structure_(device, options_, options.frames.seed, camera_, lidar_),
      seed_(options.frames.seed),
      surfaces_(device, Precision::kFloat),
      images_(HeldOutRule(log, options.frames).training(log.images), options.frames.seed, kImageStream),
      sweeps_(HeldOutRule(log, options.frames).training(log.sweeps), options.frames.seed, kSweepStream),
      length_(options_.length,
              epoch_of(options_, images_.size(), sweeps_.size()),
              log.images.size(),
              log.sweeps.size()),
      mended_(device, log, options.frames, options.fixer, options.fixer_command, options_.render) {
  if (images_.empty() && sweeps_.empty()) {
    throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  scene_.camera_filter_px2 = renderer_.options().camera_filter_px2;
  prepare_shapes(scene_.actors, options_.actor_shapes);
  if (has_shards()) sum_.emplace(device, Precision::kFloat);
  if (options_.length.automatic) options_.iterations = length_.first();
  status_.planned = options_.iterations;
  status_.camera_particles = camera_.particles.count;
  status_.lidar_particles = lidar_.particles.count;
  status_.psnr_db = status_.distance_m = status_.drop_accuracy = std::numeric_limits<double>::quiet_NaN();
}

bool Trainer::is_sound(double loss) {
  if (std::isfinite(loss)) return true;
  ++unsound_losses_;
  return false;
}

TrainReport Trainer::run(const std::function<void(const TrainStatus&)>& on_step) {
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  TrainReport report;
  report.first_iteration = status_.iteration;
  report.begin = status_;
  constexpr int kStart = 5;  // iterations: what runs away does so soon
  while (status_.iteration < options_.iterations) {
    if (options_.max_seconds > 0.0 && ranks_.any(elapsed_s() >= options_.max_seconds)) {
      report.stopped_early = true;
      break;
    }
    step();
    if (status_.iteration - report.first_iteration <= kStart) {
      // fmin and fmax leave what is not known out.
      report.begin.psnr_db = std::fmax(report.begin.psnr_db, status_.psnr_db);
      report.begin.distance_m = std::fmin(report.begin.distance_m, status_.distance_m);
      report.begin.drop_accuracy = std::fmax(report.begin.drop_accuracy, status_.drop_accuracy);
    }
    if (on_step) on_step(status_);
  }
  device_.finish();
  report.last = status_;
  report.images = images_.size();
  report.sweeps = sweeps_.size();
  report.camera_particles = camera_.particles.count;
  report.lidar_particles = lidar_.particles.count;
  structure_.report(report);
  report.pruned = pruned_;
  report.row_ranges_m = largest_correction_m(log_, truth_);
  report.rejected_gradients = camera_.adam.rejected() + lidar_.adam.rejected() + look_.rejected();
  report.unsound_particles = (camera_.particles.count - finite_ones(camera_.particles.download()).size()) +
                             (lidar_.particles.count - finite_ones(lidar_.particles.download()).size());
  report.unsound_losses = unsound_losses_;
  report.stages = length_.stages();
  report.ranks = ranks_.size();
  report.gathered_bytes = gathered_bytes_;
  report.seconds = elapsed_s();
  return report;
}

Scene Trainer::scene() const {
  Scene out = scene_;
  out.camera = finite_ones(camera_.particles.download());
  out.lidar = finite_ones(lidar_.particles.download());
  look_.store(out);
  drop_.store(out);
  return in_coherent_order(std::move(out));  // they have moved
}

StateList Trainer::state(const std::string& settings) {
  StateList list;
  list.add_fixed(kSettings, settings);
  list.add(
      kIterations,
      [this] {
        StateList::Bytes bytes(sizeof options_.iterations);
        std::memcpy(bytes.data(), &options_.iterations, bytes.size());
        return bytes;
      },
      [this](const std::string& file, std::span<const std::byte> saved) {
        need_iterations(file, saved, options_);
        if (options_.length.automatic) options_.iterations = planned_in(saved);
      });
  list.add("status", status_);
  list.add("mean/squared_error", square_);
  list.add("mean/distance", distance_);
  list.add("mean/right_drops", right_);
  list.add("unsound_losses", unsound_losses_);
  list.add("pruned", pruned_);
  camera_.add_state(list, "camera");
  lidar_.add_state(list, "lidar");
  structure_.add_state(list);
  if (options_.length.automatic) add_length(list, length_);
  add_tracks(list, scene_.actors);
  add_shapes(list, scene_.actors);
  for (TrainedSet* set : {&camera_, &lidar_}) {
    list.add_numbers(
        set == &camera_ ? "camera/poses" : "lidar/poses",
        [this, set] { return set->poses.numbers(scene_.actors); },
        [this, set](std::span<const double> numbers) { set->poses.set_numbers(scene_.actors, numbers); });
    list.add_numbers(
        set == &camera_ ? "camera/shapes" : "lidar/shapes",
        [this, set] { return set->shapes.numbers(scene_.actors); },
        [this, set](std::span<const double> numbers) { set->shapes.set_numbers(scene_.actors, numbers); });
  }
  look_.add_state(list);
  drop_.add_state(list);
  add_range_biases(list, log_, truth_);
  mended_.add_state(list);
  return list;
}

void Trainer::save(const std::filesystem::path& file, const std::string& settings) {
  state(settings).write(file);
}

void Trainer::need_one_state(const std::string& settings) {
  if (ranks_.size() == 1) return;
  std::vector<RankField> fields;
  for (const auto& [name, hash] : state(settings).hashes())
    fields.push_back({name, fmt::format("{:016x}", hash)});
  need_same(ranks_, fields);
}

void Trainer::need_settings(const std::filesystem::path& file,
                            const std::string& settings,
                            const TrainOptions& options) {
  const StateFile state(file);
  StateList::need_text(file.string(), kSettings, state.block(kSettings), settings);
  need_iterations(file.string(), state.block(kIterations), options);
}

void Trainer::resume(const std::filesystem::path& file, const std::string& settings) {
  state(settings).read(file);
  status_.planned = options_.iterations;  // may be more than when it was saved
  for (TrainedSet* set : {&camera_, &lidar_}) {
    set->fit_gradients();
    set->particles.refresh_actors();
  }
}

}  // namespace simuli
