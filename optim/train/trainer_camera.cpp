// The camera set's share of an iteration: one picture, its losses, one step of Adam.
#include <algorithm>
#include <cmath>

#include "optim/base/frames.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {

void Trainer::step_camera(double progress) {
  const std::size_t index = images_.at(static_cast<std::uint64_t>(status_.iteration));
  const ImageFrame& frame = log_.images[index];
  const SensorRays& rays = truth_.camera_rays(frame.camera);
  const auto truth = truth_.image(index);
  Pass pass = renderer_.render(camera_.particles, rays, view(frame, frame.camera), look_.environment());
  look_.grade(pass, index);
  const double values = 3.0 * std::max(1.0, static_cast<double>(truth->known));
  const ImageWeights& w = options_.image;
  const ImageLoss loss =
      pass.image_loss(truth->truth, {w.absolute / values, w.squared / values, w.dissimilarity / values});
  const bool errors = collects_errors();
  if (errors) {
    densify_->pixel_error(
        pass.frame(), pass.buffers(), pass.picture(), truth->truth.slots(), pass.ray_error());
  }
  look_.step(pass, index, static_cast<std::uint64_t>(status_.iteration), progress);
  pass.backward(
      camera_.particles, camera_.grads, {.errors = errors, .ray_gradients = offsets_.contains(frame.camera)});
  if (errors) densify_->accumulate(pass.frame(), pass.buffers(), camera_.error);
  step_pose(pass, frame.camera, camera_.grads, progress);
  regularize(camera_, options_.camera_particles);
  add_anchor_gradient(pass);
  camera_.adam.run(camera_.particles,
                   camera_.grads,
                   pass.buffers().keys,
                   row_rates(options_.camera, camera_.particles.sh_degree, progress));
  jitter(pass, camera_, kCameraSet, options_.camera, progress);
  step_actors(pass, camera_, frame.time_start_s, frame.time_end_s, progress);
  if (!is_sound(loss.absolute + loss.squared + loss.dissimilarity)) return;
  square_.add(loss.squared / values);
  status_.psnr_db = -10.0 * std::log10(square_.value());
}

}  // namespace simuli
