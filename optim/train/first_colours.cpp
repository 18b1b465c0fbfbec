#include "optim/train/first_colours.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "optim/base/evenly_spread.hpp"

namespace simuli {
namespace {

/// Of the pictures of a camera, and of the iterations that follow.
constexpr std::size_t kOneOf = 4, kIterationsEach = 10;
/// Pixels: what shows less moves less.
constexpr double kSteady_px = 0.1;

std::vector<std::size_t> some_of_each_camera(const TrainerState& state) {
  const std::vector<std::size_t>& all = state.images.frames();
  const std::size_t most = static_cast<std::size_t>(state.options.iterations) / kIterationsEach;
  std::vector<std::size_t> some;
  for (const LogCamera& camera : state.log.cameras) {
    const std::vector<std::size_t> own = own_of(
        all, state.log.images, [&](const ImageFrame& frame) { return frame.camera == camera.model.name; });
    const std::size_t few = std::min(own.size() / kOneOf, most * own.size() / all.size());
    const std::vector<std::size_t> spread = evenly_spread(own, few);
    some.insert(some.end(), spread.begin(), spread.end());
  }
  return some;
}

/// [slots] 1 where the picture is known.
std::vector<float> known_slots(const RayValues& truth) {
  const std::vector<std::int32_t>& ray_of_slot = truth.rays().grid().ray_of_slot;
  const std::vector<float> red = truth.slots().download_float();
  std::vector<float> known(ray_of_slot.size());
  for (std::size_t i = 0; i < known.size(); ++i)
    known[i] = ray_of_slot[i] >= 0 && red[i] >= 0.0F ? 1.0F : 0.0F;
  return known;
}

}  // namespace

void solve_first_colours(TrainerState& state, const std::function<void(std::size_t, std::size_t)>& progress) {
  TrainedSet& set = state.camera;
  const std::size_t stride = set.particles.stride;
  if (set.particles.count == 0 || state.images.empty()) return;
  const std::vector<std::size_t> pictures = some_of_each_camera(state);
  if (pictures.empty()) return;

  DensifyStage shares(state.device, Precision::kFloat);
  RealBuffer weight_px(state.device, "weights in pictures", Precision::kFloat, set.particles.count);
  weight_px.fill(0.0);
  const auto rows = static_cast<Eigen::Index>(set.particles.count);
  std::vector<float> read(3 * stride);  // the three rows of degree 0, of gradients or parameters
  Eigen::Map<Eigen::ArrayX3f, 0, Eigen::OuterStride<>> colours(
      read.data(), rows, 3, Eigen::OuterStride<>(static_cast<Eigen::Index>(stride)));
  Eigen::ArrayX3d missing = Eigen::ArrayX3d::Zero(rows, 3);  // times weight, px
  for (std::size_t done = 0; done < pictures.size(); ++done) {
    if (progress) progress(done, pictures.size());
    const std::size_t index = pictures[done];
    const auto truth = state.truth.image(index);
    Pass pass = state.show_picture(index);
    static_cast<void>(pass.image_loss(truth->truth, {.squared = 0.5}));
    pass.ray_error().assign(known_slots(truth->truth));
    state.look.backward(pass, index);
    pass.backward(set.particles, set.grads, {.errors = true});
    shares.accumulate(pass.frame(), pass.buffers(), pass.gradients(), weight_px);
    set.grads.as_float().download_at(kShRow * stride, read);
    missing -= colours.cast<double>() / kSh0;
  }

  const std::vector<float> shown = weight_px.download_float();
  const Eigen::ArrayXd weight =
      Eigen::Map<const Eigen::ArrayXf>(shown.data(), rows).cast<double>() + kSteady_px;
  const Eigen::ArrayX3d step = missing.colwise() / weight / kSh0;
  Buffer<float>& params = set.particles.params.as_float();
  params.download_at(kShRow * stride, read);
  colours += step.isFinite().select(step, 0.0).cast<float>();
  params.upload_at(kShRow * stride, read);
}

}  // namespace simuli
