#include "optim/train/judgement.hpp"

#include <cmath>
#include <fmt/format.h>

namespace simuli {
namespace {

// Thresholds between sound and diverged trainings (docs/DECISIONS.md, "Training safety").
constexpr int kFewest = 20;  // fewer iterations give no verdict
constexpr int kEnough = 100;  // so many iterations should have gained something
constexpr double kLost_dB = 2.0;
constexpr double kFailed_dB = 6.0;  // a loss of four times the squared error
constexpr double kGained_dB = 1.0;
// Above this PSNR a training is sound whatever its start was: an initialisation with pictures of one colour has
// 90 dB.
constexpr double kSound_dB = 40.0;
constexpr double kFar_m = 2.0;
constexpr double kLostDecisions = 0.03;
constexpr double kFailedShare = 0.5;  // share of particles with non-finite parameters

}  // namespace

Judgement judge(const TrainReport& r) {
  Judgement out;
  const int done = r.last.iteration - r.first_iteration;
  const auto particles = static_cast<double>(r.camera_particles + r.lidar_particles);
  if (static_cast<double>(r.unsound_particles) > kFailedShare * particles) {
    out.failure = fmt::format(
        "training: {} of {:.0f} particles are no numbers at the end, allowed half of them; smaller rates?",
        r.unsound_particles,
        particles);
    return out;
  }
  if (r.sweeps > 0 && r.lidar_particles == 0) {
    out.warnings.emplace_back("no sweep has a return to start from: the LiDAR set is empty");
  }
  if (done < kFewest) return out;
  const double gain_db = r.last.psnr_db - r.begin.psnr_db;
  const bool is_sound = r.last.psnr_db >= kSound_dB;
  if (gain_db < -kFailed_dB && !is_sound) {
    out.failure = fmt::format(
        "training: PSNR of the training pictures fell from {:.1f} to {:.1f} dB, allowed {:.0f} dB less; "
        "smaller "
        "rates?",
        r.begin.psnr_db,
        r.last.psnr_db,
        kFailed_dB);
    return out;
  }
  if (gain_db < -kLost_dB && !is_sound) {
    out.warnings.push_back(
        fmt::format("PSNR of the training pictures fell from {:.1f} to {:.1f} dB: are rates too large?",
                    r.begin.psnr_db,
                    r.last.psnr_db));
  } else if (gain_db < kGained_dB && !is_sound && done >= kEnough && r.first_iteration == 0) {
    out.warnings.push_back(
        fmt::format("PSNR of the training pictures is {:.1f} dB after {:.1f} at the start: are poses, times "
                    "and the order of "
                    "pictures right?",
                    r.last.psnr_db,
                    r.begin.psnr_db));
  }
  if (r.last.distance_m > kFar_m) {
    out.warnings.push_back(fmt::format(
        "distances of the training sweeps are off by {:.1f} m in the mean: are poses and times right?",
        r.last.distance_m));
  }
  const double fewer_right = r.begin.drop_accuracy - r.last.drop_accuracy;
  if (fewer_right > kLostDecisions) {
    out.warnings.push_back(fmt::format("ray-drop decisions fell from {:.1f} to {:.1f} % right",
                                       100.0 * r.begin.drop_accuracy,
                                       100.0 * r.last.drop_accuracy));
  }
  return out;
}

}  // namespace simuli
