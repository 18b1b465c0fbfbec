#include "host/device/render/scene/pass.hpp"

#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/scene/pass_state.hpp"
#include "host/device/render/scene/slot_results.hpp"

namespace simuli {
namespace {

[[noreturn]] void misused(const char* call, const std::string& found, const std::string& allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", call, found, allowed));
}

void need(bool holds, const char* call, const char* found, const char* allowed) {
  if (!holds) misused(call, found, allowed);
}

}  // namespace

void Pass::State::need_grid(const char* call, const ColorGridBuffers& of, std::size_t index) const {
  const std::size_t count = of.grid.count() / of.reals();
  if (index >= count) misused(call, fmt::format("grid {}", index), fmt::format("one of {}", count));
  need(of.grid.precision() == options.precision, call, "grids of the other precision", "the renderer's");
}

void Pass::State::need_truth(const char* call, const RayValues& truth, std::size_t channels) const {
  need(truth.rays().is_of_sensor_of(*frame.rays), call, "values of other rays", "those of the rays rendered");
  if (truth.channels() >= channels) return;
  misused(call, fmt::format("{} channels", truth.channels()), std::to_string(channels));
}

void Pass::State::need_gradient(const char* call) const {
  need(frame.gradient != Gradient::kNone, call, "no gradient", "a loss or set_output_gradients() before");
  need(frame.gradient == Gradient::kOfOutputs,
       call,
       "the gradient of a graded picture",
       "grade_backward() before");
}

void Pass::State::need_particles(const char* call, const ParticleBuffers& particles) const {
  need(particles.id() == frame.particles, call, "other particles", "those rendered");
  need(!particles.paged, call, "a part of a set", "all of it on the device");
  if (particles.count == frame.params.particles && particles.stride == frame.params.stride) return;
  misused(call,
          fmt::format("{} particles", particles.count),
          fmt::format("{} as rendered", frame.params.particles));
}

Pass::State& Pass::last(const char* call) const {
  if (state_->frames != number_) {
    misused(call,
            fmt::format("pass {} of a renderer that has gone on to {}", number_, state_->frames),
            "its last one, whose buffers hold the frame");
  }
  return *state_;
}

const SensorRays& Pass::rays() const { return *last("rays").frame.rays; }
const shared::FrameParams& Pass::frame() const { return last("frame").frame.params; }
const Variant& Pass::variant() const { return last("variant").frame.stages->own; }
const FrameBuffers& Pass::buffers() const { return last("buffers").buffers; }
const GradientBuffers& Pass::gradients() const { return last("gradients").gradients; }
const RealBuffer& Pass::picture() const { return last("picture").shown(); }

bool Pass::is_graded() const { return last("is_graded").frame.graded; }
bool Pass::has_median() const { return last("has_median").frame.stages->own.frame.median; }

RealBuffer& Pass::ray_error() {
  State& s = last("ray_error");
  s.gradients.ray_error.reserve(s.frame.params.slots);
  s.frame.has_ray_error = true;
  return s.gradients.ray_error;
}

void Pass::grade(const ColorGridBuffers& grids, std::size_t index) {
  State& s = last("grade");
  const RayGrid& grid = s.frame.rays->grid();
  need(grid.type == SensorType::kCamera, "grade", "a LiDAR's frame", "a camera's");
  need(!s.frame.graded, "grade", "a picture that has been graded", "one that has not");
  s.need_grid("grade", grids, index);
  s.grid_stages(grids).forward.run(
      s.frame.params, grid.width, grid.height, grids, index, s.buffers.blended, s.pictures.picture);
  s.frame.graded = true;
  s.frame.gradient = State::Gradient::kNone;
}

RayResults Pass::results() const {
  const State& s = last("results");
  return results_of(s.frame.rays->grid(),
                    s.buffers.blended.out.download_float(),
                    s.frame.graded ? s.pictures.picture.download_float() : std::vector<float>{},
                    s.frame.background,
                    s.frame.stages->own.frame.median);
}

void Pass::exchange_outputs(RealBuffer& outputs, RealBuffer& picture) {
  State& s = last("exchange_outputs");
  s.buffers.blended.out.exchange(outputs);
  if (s.frame.graded) s.pictures.picture.exchange(picture);
  ++s.frames;
}

void Pass::set_drop(const RayDrop::Parameters& drop) {
  State& s = last("set_drop");
  need(s.frame.rays->grid().type == SensorType::kLidar, "set_drop", "a camera's frame", "a LiDAR's");
  s.frame.sensor.drop = shared::from_reals<shared::DropConstants>(drop);
  s.buffers.constants.sensor.assign(shared::reals_of(s.frame.sensor));
}

ImageLoss Pass::image_loss(const RayValues& truth, const ImageLossScale& scale) {
  State& s = last("image_loss");
  need(s.frame.rays->grid().type == SensorType::kCamera, "image_loss", "a LiDAR's frame", "a camera's");
  s.need_truth("image_loss", truth, scale.sky > 0.0 ? 4 : 3);
  const ImageLoss loss = s.image_loss.run(
      s.frame.params, s.buffers.rays, s.buffers.blended.out, s.shown(), truth.slots(), scale, s.gradients);
  s.has_gradient();
  return loss;
}

LidarLoss Pass::lidar_loss(const RayValues& truth, const LidarLossScale& scale) {
  State& s = last("lidar_loss");
  need(s.frame.rays->grid().type == SensorType::kLidar, "lidar_loss", "a camera's frame", "a LiDAR's");
  s.need_truth("lidar_loss", truth, 2);
  const LidarLoss loss = s.lidar_loss.run(s.frame.params,
                                          s.buffers.constants,
                                          s.buffers.rays,
                                          s.buffers.blended,
                                          truth.slots(),
                                          scale,
                                          s.gradients);
  s.has_gradient();
  return loss;
}

void Pass::set_output_gradients(const std::vector<double>& gradients) {
  State& s = last("set_output_gradients");
  s.gradients.grad_out.assign(s.frame.rays->to_slots(gradients, SIM_O_MEDIAN));
  s.has_gradient();
}

void Pass::grade_backward(const ColorGridBuffers& grids,
                          std::size_t index,
                          const ColorGridScale& scale,
                          RealBuffer& grid_grads) {
  State& s = last("grade_backward");
  need(s.frame.gradient == State::Gradient::kOfGraded,
       "grade_backward",
       "no gradient of a graded picture",
       "grade() and a loss before, once");
  s.need_grid("grade_backward", grids, index);
  const RayGrid& grid = s.frame.rays->grid();
  auto& stage = s.grid_stages(grids).back;
  if (!stage) stage.emplace(s.device, grids);
  stage->run(s.frame.params,
             grid.width,
             grid.height,
             grids,
             index,
             scale,
             s.buffers.blended,
             s.gradients,
             grid_grads);
  s.frame.gradient = State::Gradient::kOfOutputs;
}

void Pass::environment_backward(const EnvironmentBuffers& environment,
                                double tv_scale,
                                RealBuffer& texture_grads) {
  State& s = last("environment_backward");
  s.need_gradient("environment_backward");
  need(&environment == s.frame.environment,
       "environment_backward",
       "an environment that was not rendered",
       "the one that was");
  auto& stage = s.environment_back;
  if (!stage) stage.emplace(s.device, s.options.precision, s.options.shape.lanes);
  stage->run(s.frame.params,
             environment,
             tv_scale,
             s.buffers.constants,
             s.buffers.rays,
             s.buffers.blended,
             s.gradients,
             texture_grads);
}

void Pass::backward(const ParticleBuffers& particles, RealBuffer& param_grads, const BackwardExtras& extras) {
  State& s = last("backward");
  s.need_particles("backward", particles);
  State::Stages& stages = *s.frame.stages;
  const Variant& own = stages.own;
  if (!stages.render_back) need_gradients(s.options, "backward");
  need(particles.sh_storage == ShStorage::kFull, "backward", "coefficients in halves", "full ones");
  s.need_gradient("backward");
  need(!extras.errors || s.frame.has_ray_error, "backward", "no ray errors", "those of ray_error() before");
  param_grads.reserve(particles.params.count());
  if (!stages.render_back) stages.render_back.emplace(s.device, own);
  if (!stages.project_back) stages.project_back.emplace(s.device, own);
  stages.render_back->run(s.frame.params, particles, s.frame.rays->buffers(), s.buffers, extras, s.gradients);
  stages.project_back->run(s.frame.params, particles, s.buffers, s.gradients, param_grads);
  if (!s.frame.shapes.empty()) {
    if (!s.deform_back) s.deform_back.emplace(s.device, s.options.precision);
    s.deform_back->run(s.frame.shapes, particles, s.buffers, param_grads);
  }
  s.frame.went_back = true;
}

std::vector<ActorPoseGradient> Pass::pose_gradients(const ParticleBuffers& particles) {
  State& s = last("pose_gradients");
  need(s.frame.went_back, "pose_gradients", "no gradients", "backward() before");
  s.need_particles("pose_gradients", particles);
  return s.actors.pose_gradients(
      particles, s.buffers.projected, s.gradients, s.frame.stages->own.frame.actor_motion);
}

std::vector<DeformationGradient> Pass::deformation_gradients() {
  State& s = last("deformation_gradients");
  need(s.frame.went_back, "deformation_gradients", "no gradients", "backward() before");
  if (s.frame.shapes.empty()) return {};
  return s.deform_back->gradients(s.frame.shapes);
}

void Pass::raise_largest_weights(Buffer<std::uint32_t>& largest) {
  State& s = last("raise_largest_weights");
  need(!s.frame.paged, "raise_largest_weights", "a part of a set", "all of it on the device");
  if (largest.count() < s.frame.params.particles) {
    misused("raise_largest_weights", fmt::format("{} weights", largest.count()), "one for each particle");
  }
  State::Stages& stages = *s.frame.stages;
  if (!stages.largest_weight) stages.largest_weight.emplace(s.device, stages.own);
  stages.largest_weight->run(s.frame.params, s.frame.rays->buffers(), s.buffers, largest);
}

void Pass::keep_surfaces(SeenSurfaces& seen) {
  State& s = last("keep_surfaces");
  need(s.frame.rays->grid().type == SensorType::kCamera, "keep_surfaces", "a LiDAR's frame", "a camera's");
  seen.sensor.assign(shared::reals_of(s.frame.sensor));
  s.buffers.blended.out.exchange(seen.out);
  ++s.frames;
}

void Pass::show_from(const SeenSurfaces& recorded, const RayValues& picture, RayValues& shown) {
  State& s = last("show_from");
  const RayGrid& grid = s.frame.rays->grid();
  need(grid.type == SensorType::kCamera, "show_from", "a LiDAR's frame", "a camera's");
  s.need_truth("show_from", picture, 3);
  s.need_truth("show_from", shown, 3);
  need(recorded.out.count() >= std::size_t{s.frame.params.slots} * (SIM_O_DISTANCE + 1),
       "show_from",
       "surfaces of another camera",
       "those kept of its own");
  State::Stages& stages = *s.frame.stages;
  if (!stages.off_trajectory) stages.off_trajectory.emplace(s.device, stages.own);
  stages.off_trajectory->run(s.frame.params,
                     grid,
                     s.frame.rays->map().slot_of_ray,
                     s.buffers,
                     recorded,
                     picture.slots(),
                     shown.slots());
}

}  // namespace simuli
