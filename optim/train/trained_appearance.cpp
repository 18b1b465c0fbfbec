#include "optim/train/trained_appearance.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "optim/base/frames.hpp"

namespace simuli {
namespace {

constexpr Precision kFloat = Precision::kFloat;
constexpr double kLookFinalShare = 0.1;  // final share of both learning rates
/// In this first share of a training the environment below the horizon is black. In the ground's own colour it
/// would replace ground particles and leave holes (docs/DECISIONS.md, "Sky and environment").
constexpr double kDarkShare = 0.5;
/// Weights of squared differences between neighbouring vertices of a grid, and to the identity; METHOD's table
/// has the paper's values.
constexpr double kGridVariation = 40.0, kGridDrift = 0.001;
/// Grids with fewer steps than this get proportionally higher rates, up to the factor kFastestGrid
/// (docs/DECISIONS.md, "Colour grids").
constexpr double kGridSteps = 60.0, kFastestGrid = 8.0;

/// Number of texels down to 5 degrees below the horizon, at least one block of Adam; texels below show ground.
std::ptrdiff_t sky_texels(const EnvironmentMap& map) {
  constexpr double kShare = (90.0 + 5.0) / 180.0;
  auto texels = static_cast<std::ptrdiff_t>(std::ceil(kShare * map.height)) * map.width;
  while (4 * texels % static_cast<std::ptrdiff_t>(AdamStage::kStep) != 0) texels += map.width;
  return texels;
}

ColorGrids starting_grids(const Log& log, const Scene& scene, const GridPlan& plan) {
  std::vector<ColorGrids::Frame> frames;
  for (const std::size_t i : plan.images) {
    const ImageFrame& image = log.images[i];
    frames.push_back({image.camera, 0.5 * (image.time_start_s + image.time_end_s)});
  }
  const auto [x, y, luminance] = GridPlan::kSize;
  ColorGrids grids = ColorGrids::identity(x, y, luminance, std::move(frames));
  const ColorGrids& own = scene.color_grids;
  const bool same = own.frames == grids.frames && own.values.size() == grids.values.size();
  return same ? own : grids;
}

/// Returns the grid of each training picture, [log.images].
std::vector<std::size_t> grid_of_images(const Log& log,
                                        const GridPlan& plan,
                                        const std::vector<std::size_t>& training) {
  std::vector<std::size_t> out(log.images.size(), 0);
  for (std::size_t k = 0; k < training.size(); ++k) {
    const std::string& camera = log.images[training[k]].camera;
    const auto own = std::find_if(plan.images.begin(), plan.images.end(), [&](std::size_t image) {
      return plan.by_camera ? log.images[image].camera == camera : image == training[k];
    });
    out[training[k]] = static_cast<std::size_t>(own - plan.images.begin());
  }
  return out;
}

}  // namespace

GridPlan plan_grids(const AppearanceOptions& options, const Log& log, const std::vector<std::size_t>& training) {
  if (options.color_grids == ColorGridsOf::kNone) return {};
  GridPlan plan{{}, true};
  for (const std::size_t i : training) {
    const bool is_first = std::none_of(plan.images.begin(), plan.images.end(), [&](std::size_t image) {
      return log.images[image].camera == log.images[i].camera;
    });
    if (is_first) plan.images.push_back(i);
  }
  const bool is_of_pictures = options.color_grids == ColorGridsOf::kPictures || plan.images.size() == 1;
  return is_of_pictures ? GridPlan{training, false} : plan;
}

TrainedAppearance::TrainedAppearance(const Device& device,
                         const Log& log,
                         const Scene& scene,
                         const TrainingOptions& options)
    : options_(options.train.appearance) {
  if (!scene.environment.empty()) {
    EnvironmentBuffers buffers(device, scene.environment, kFloat);
    const std::size_t reals = buffers.texture.count();
    environment_.emplace(Environment{std::move(buffers),
                                     RealBuffer(device, "environment gradients", kFloat, reals),
                                     AdamStage(device, kFloat, reals),
                                     {}});
    if (!log.sweeps.empty()) {
      const std::vector<float>& texels = scene.environment.texels;
      environment_->ground.assign(texels.begin() + 3 * sky_texels(scene.environment), texels.end());
      environment_->show_ground(true);
    }
  }
  const std::vector<std::size_t> images = HeldOutRule(log, options.frames).training(log.images);
  const GridPlan plan = plan_grids(options_, log, images);
  if (plan.images.empty()) return;
  ColorGrids frames = starting_grids(log, scene, plan);
  ColorGridBuffers buffers(device, frames, kFloat);
  const std::size_t reals = buffers.grid.count();
  grids_.emplace(Grids{std::move(frames),
                       grid_of_images(log, plan, images),
                       std::move(buffers),
                       RealBuffer(device, "colour grid gradients", kFloat),
                       AdamStage(device, kFloat, reals)});
}

double TrainedAppearance::colour_epsilon(std::size_t parts) const {
  return options_.least_share / (3.0 * static_cast<double>(parts));
}

double TrainedAppearance::harmonics_epsilon(std::size_t particles) const {
  return static_cast<double>(kSh0) * colour_epsilon(particles);
}

const EnvironmentBuffers* TrainedAppearance::environment() const {
  return environment_ ? &environment_->buffers : nullptr;
}

void TrainedAppearance::grade(Pass& pass, std::size_t image) {
  if (grids_) pass.grade(grids_->buffers, grids_->of_image[image]);
}

void TrainedAppearance::backward(Pass& pass, std::size_t image) {
  if (grids_) {
    Grids& g = *grids_;
    const auto values = static_cast<double>(g.frames.values_per_frame());
    pass.grade_backward(
        g.buffers, g.of_image[image], {kGridVariation / values, kGridDrift / values}, g.grads);
  }
  if (environment_) {
    Environment& e = *environment_;
    pass.environment_backward(e.buffers, 0.0, e.grads);
  }
}

/// `picture`: number of pictures before; `pictures`: total number.
void TrainedAppearance::step_grid(std::size_t image, std::uint64_t picture, double pictures, double progress) {
  if (!grids_) return;
  Grids& g = *grids_;
  const double steps = pictures / static_cast<double>(g.frames.frames.size());
  const double rate = options_.grid_rate * std::clamp(kGridSteps / steps, 1.0, kFastestGrid);
  // Each grid takes the same number of steps.
  g.adam.run_dense(g.buffers.grid,
                   g.grads,
                   g.of_image[image] * g.buffers.reals(),
                   g.grads.count(),
                   std::pow(kLookFinalShare, progress) * rate,
                   picture / g.frames.frames.size() + 1);
}

void TrainedAppearance::Environment::show_ground(bool is_black) {
  is_dark = is_black;
  std::vector<float> texels(ground.size() / 3 * 4, 0.0F);
  for (std::size_t i = 0; i < ground.size() && !is_black; ++i) texels[i / 3 * 4 + i % 3] = ground[i];
  buffers.texture.as_float().upload_at(buffers.texture.count() - texels.size(), texels);
}

void TrainedAppearance::step_environment(std::uint64_t iteration, double progress) {
  if (!environment_) return;
  Environment& e = *environment_;
  if (e.is_dark && progress >= kDarkShare) e.show_ground(false);
  const double rate = std::pow(kLookFinalShare, progress) * options_.environment_rate;
  const auto texels = static_cast<std::size_t>(e.buffers.width) * static_cast<std::size_t>(e.buffers.height);
  const std::size_t learned = e.buffers.texture.count() - e.ground.size() / 3 * 4;
  e.adam.run_dense(
      e.buffers.texture, e.grads, 0, learned, rate, iteration + 1, kAdamEpsilon + colour_epsilon(texels));
}

TrainedAppearance::Gradients TrainedAppearance::gradients() const {
  Gradients out;
  if (grids_) out.grid = grids_->grads.download_float();
  if (environment_) out.environment = environment_->grads.download_float();
  return out;
}

void TrainedAppearance::step(const std::vector<Shard>& shards,
                       std::uint64_t iteration,
                       int iterations,
                       ShardSum* sum) {
  const double progress = static_cast<double>(iteration) / std::max(1, iterations);
  if (environment_ && sum != nullptr) {
    RealBuffer& grads = environment_->grads;
    grads.fill(0.0);
    for (const Shard& shard : shards) {
      sum->add_all(shard.gradients.environment, 1.0 / static_cast<double>(shards.size()), grads);
    }
  }
  step_environment(iteration, progress);
  const double pictures = static_cast<double>(iterations) * static_cast<double>(shards.size());
  for (std::size_t i = 0; grids_ && i < shards.size(); ++i) {
    if (sum != nullptr) grids_->grads.assign(std::span<const float>(shards[i].gradients.grid));
    step_grid(shards[i].image, iteration * shards.size() + i, pictures, progress);
  }
}

std::uint32_t TrainedAppearance::rejected() const {
  return (environment_ ? environment_->adam.rejected() : 0U) + (grids_ ? grids_->adam.rejected() : 0U);
}

void TrainedAppearance::store(Scene& scene) const {
  if (environment_) {
    scene.environment = environment_->buffers.download();
    const std::vector<float>& ground = environment_->ground;
    std::copy(ground.begin(), ground.end(), scene.environment.texels.end() - std::ssize(ground));
  }
  scene.color_grids = {};
  if (!grids_) return;
  scene.color_grids = grids_->frames;
  grids_->buffers.download(scene.color_grids);
}

void TrainedAppearance::add_state(StateList& list) {
  const auto add = [&list](const std::string& name, RealBuffer& values, AdamStage& adam) {
    list.add(name, values);
    list.add(name + "/first_moment", adam.first_moment());
    list.add(name + "/second_moment", adam.second_moment());
    list.add(name + "/rejections", adam.rejections());
  };
  if (environment_) add("environment", environment_->buffers.texture, environment_->adam);
  if (grids_) add("color_grids", grids_->buffers.grid, grids_->adam);
}

}  // namespace simuli
