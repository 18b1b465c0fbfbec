#include "optim/train/trained_drop.hpp"

#include <algorithm>
#include <cmath>

#include "optim/base/frames.hpp"

namespace simuli {

constexpr double kDropFinalShare = 0.1;  // final share of the learning rate
constexpr int kSteps = 10;  // steps of a function per sweep that trains it; the sweep is rendered once

TrainedDrop::TrainedDrop(const Log& log, const Scene& scene, const TrainingOptions& options)
    : options_(options.train.ray_drop) {
  if (options_.rate <= 0.0) {
    for (const RayDrop& drop : scene.ray_drop) functions_[drop.lidar].value = drop.parameters;
    return;
  }
  for (const LogLidar& lidar : log.lidars) {
    const std::string& name = name_of(lidar.model);
    const auto known = std::find_if(
        scene.ray_drop.begin(), scene.ray_drop.end(), [&](const RayDrop& d) { return d.lidar == name; });
    functions_[name].value = known == scene.ray_drop.end() ? RayDrop::start() : known->parameters;
  }
  teaches_function_.assign(log.sweeps.size(), true);
  teaches_particles_ = teaches_function_;
  const std::vector<std::size_t> sweeps = HeldOutRule(log, options.frames).training(log.sweeps);
  const auto every = static_cast<std::size_t>(options_.apart);
  if (every == 0 || sweeps.size() < 2 * every) return;  // too few sweeps to reserve some
  for (std::size_t place = 0; place < sweeps.size(); ++place) {
    const bool function = place % every == every / 2;
    teaches_function_[sweeps[place]] = function;
    teaches_particles_[sweeps[place]] = !function;
  }
}

RayDrop::Parameters TrainedDrop::of(const std::string& lidar) const {
  const auto found = functions_.find(lidar);
  return found == functions_.end() ? RayDrop::of_logits() : found->second.value;
}

LidarLossScale TrainedDrop::share(std::size_t sweep, LidarLossScale scale) const {
  if (options_.rate <= 0.0) return scale;
  scale.function_entropy = teaches_function_[sweep] ? scale.entropy : 0.0;
  if (!teaches_particles_[sweep]) scale.entropy = 0.0;
  return scale;
}

LidarLoss TrainedDrop::learn(Pass& pass,
                             const RayValues& truth,
                             std::size_t sweep,
                             const std::string& lidar,
                             const LidarLossScale& scale,
                             double progress,
                             std::vector<Function>& taught) const {
  const LidarLossScale own = share(sweep, scale);
  if (own.function_entropy == 0.0) return pass.lidar_loss(truth, own);
  std::array<double, RayDrop::kParameters> rates{};
  rates.fill(options_.rate * std::pow(kDropFinalShare, progress));
  Function function = functions_.at(lidar);
  for (int look = 0; look < kSteps; ++look) {
    function.step(pass.lidar_loss(truth, {.function_entropy = own.function_entropy}).drop, rates);
    pass.set_drop(function.value);
  }
  taught.push_back(function);
  return pass.lidar_loss(truth, own);
}

void TrainedDrop::take(const std::string& lidar, const std::vector<Function>& functions) {
  if (functions.empty()) return;
  Function mean;
  const double share = 1.0 / static_cast<double>(functions.size());
  for (const Function& function : functions) {
    for (std::size_t i = 0; i < mean.value.size(); ++i) {
      mean.value[i] += share * function.value[i];
      mean.first[i] += share * function.first[i];
      mean.second[i] += share * function.second[i];
    }
    mean.steps = std::max(mean.steps, function.steps);
  }
  functions_.at(lidar) = mean;
}

void TrainedDrop::store(Scene& scene) const {
  scene.ray_drop.clear();
  for (const auto& [name, function] : functions_) scene.ray_drop.push_back({name, function.value});
}

void TrainedDrop::add_state(StateList& list) {
  for (auto& [name, function] : functions_) list.add("ray_drop/" + name, function);
}

}  // namespace simuli
