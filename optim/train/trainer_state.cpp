#include "optim/train/trainer_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/scene/particle_order.hpp"
#include "io/base/state_file.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/base/packed.hpp"
#include "optim/train/memory.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kIterations = "iterations";  // planned iterations
constexpr const char* kLength = "length";

constexpr double kLeastSkyFrom_m = 100.0, kSkyFrom = 0.9;

double farthest_m(const GaussianSet& set) {
  if (set.size() == 0) return 0.0;
  return std::sqrt(set.mean().cast<double>().rowwise().squaredNorm().maxCoeff());
}

enum Stream : std::uint64_t { kImageStream = 1, kSweepStream = 2 };

RenderOptions training_options(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

/// Returns the options with particle rates for steps of several frames.
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
  TrainOptions fitted = with_rates_of_shards(options.train);
  fitted.lidar_every = iterations_a_sweep(options, log);
  return fitted;
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

/// Adds the learned range biases by row.
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

/// Adds the learned tracks and shapes of actors.
void add_actors(StateList& list, std::vector<Actor>& actors) {
  list.add(
      "actors",
      [&actors] {
        Packed packed;
        packed(actors);
        return packed.bytes();
      },
      [&actors](const std::string& file, std::span<const std::byte> saved) {
        Packed packed({saved.begin(), saved.end()}, file, "actors");
        packed(actors);
        packed.need_end();
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

TrainerState::TrainerState(const Device& on, const Log& of_log, Scene start, const TrainingOptions& training)
    : log(of_log),
      scene(in_coherent_order(std::move(start))),
      actor_margin_m(training.init.actor_margin_m),
      sky_from_m(std::max(kLeastSkyFrom_m, kSkyFrom * farthest_m(scene.camera))),
      options(fitting(on, of_log, scene, training)),
      seed(training.frames.seed),
      device(on),
      renderer(on, training_options(options.render)),
      truth(on, of_log, training, renderer.options()),
      camera(on, scene.camera, options.actor_poses, options.learn_shapes),
      lidar(on, scene.lidar, options.actor_poses, options.learn_shapes),
      appearance(on, of_log, scene, training),
      drop(of_log, scene, training),
      images(HeldOutRule(of_log, training.frames).training(of_log.images), seed, kImageStream),
      sweeps(HeldOutRule(of_log, training.frames).training(of_log.sweeps), seed, kSweepStream),
      structure(on, options, epoch_of(options, images.size(), sweeps.size()), seed, camera, lidar),
      repaired(on, of_log, training.frames, training.fixer, training.fixer_command, options.render),
      length(options.length,
             epoch_of(options, images.size(), sweeps.size()),
             of_log.images.size(),
             of_log.sweeps.size()) {
  if (images.empty() && sweeps.empty()) {
    throw_input_error(of_log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  scene.camera_filter_px2 = renderer.options().camera_filter_px2;
  // Walls that no picture shows keep the colours of similar parts nearby. Where they are visible between
  // occluder edges, pictures would train them with the occluders' colours.
  camera.freeze_colours(unseen_walls(scene.camera));
  if (options.learn_shapes) prepare_shapes(scene.actors);
  if (options.length.automatic) options.iterations = length.first();
  status.planned = options.iterations;
  status.camera_particles = camera.particles.count;
  status.lidar_particles = lidar.particles.count;
  status.psnr_db = status.distance_m = status.drop_accuracy = std::numeric_limits<double>::quiet_NaN();
}

LearningRates TrainerState::rates(SetNumber number) const {
  return paced(number == kCameraSet ? options.camera : options.lidar, options.iterations);
}

StateList TrainerState::list(const std::string& settings) {
  StateList states;
  states.add_fixed(kSettings, settings);
  states.add(
      kIterations,
      [this] {
        StateList::Bytes bytes(sizeof options.iterations);
        std::memcpy(bytes.data(), &options.iterations, bytes.size());
        return bytes;
      },
      [this](const std::string& file, std::span<const std::byte> saved) {
        need_iterations(file, saved, options);
        if (options.length.automatic) options.iterations = planned_in(saved);
      });
  states.add("status", status);
  states.add("mean/squared_error", square);
  states.add("mean/distance", distance);
  states.add("mean/right_drops", right);
  states.add("unsound_losses", unsound_losses);
  states.add("pruned", pruned);
  states.add("sky_from_m", sky_from_m);
  camera.add_state(states, "camera");
  lidar.add_state(states, "lidar");
  structure.add_state(states);
  if (options.length.automatic) add_length(states, length);
  add_actors(states, scene.actors);
  for (TrainedSet* set : {&camera, &lidar}) {
    states.add_numbers(
        set == &camera ? "camera/poses" : "lidar/poses",
        [this, set] { return set->poses.numbers(scene.actors); },
        [this, set](std::span<const double> numbers) { set->poses.set_numbers(scene.actors, numbers); });
    states.add_numbers(
        set == &camera ? "camera/shapes" : "lidar/shapes",
        [this, set] { return set->shapes.numbers(scene.actors); },
        [this, set](std::span<const double> numbers) { set->shapes.set_numbers(scene.actors, numbers); });
  }
  appearance.add_state(states);
  drop.add_state(states);
  add_range_biases(states, log, truth);
  repaired.add_state(states);
  return states;
}

void TrainerState::need_settings(const std::filesystem::path& file,
                                 const std::string& settings,
                                 const TrainOptions& options) {
  const StateFile state(file);
  StateList::need_text(file.string(), kSettings, state.block(kSettings), settings);
  need_iterations(file.string(), state.block(kIterations), options);
}

}  // namespace simuli
