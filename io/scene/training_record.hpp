#pragma once
// How a scene was made: the key "training" of scene.json.
#include <optional>
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// What the frames that a training held out say of its scene, as `simuli eval` says it. NaN: no such frame.
struct HeldOutScores {
  std::size_t images = 0, sweeps = 0;  // compared
  int image_width = 0;                 // px, of the pictures compared
  int image_height = 0;
  double psnr_db = 0.0;
  double ssim = 0.0;
  double distance_median_m = 0.0;
  double intensity_rmse = 0.0;
  double raydrop_accuracy = 0.0;
  double chamfer_m = 0.0;
};
/// Calls field(key, value) for each, as JSON and Python have them.
template <class Scores, class Field>
void visit_scores(Scores& s, Field&& field) {
  field("images", s.images);
  field("sweeps", s.sweeps);
  field("image_width_px", s.image_width);
  field("image_height_px", s.image_height);
  field("psnr_db", s.psnr_db);
  field("ssim", s.ssim);
  field("distance_median_m", s.distance_median_m);
  field("intensity_rmse", s.intensity_rmse);
  field("raydrop_accuracy", s.raydrop_accuracy);
  field("chamfer_m", s.chamfer_m);
}

/// What it takes to make the scene again, and to know which frames it has not seen.
struct TrainingRecord {
  std::string log_name = {};
  std::string log_hash = {};  // io/log/log.hpp
  FrameSelection frames = {};
  std::vector<SensorUse> sensors = {};            // what that made of each one's frames; empty: not told
  std::vector<std::string> labels_left_out = {};  // actors of the log that it took for none
  int iterations = 0;                             // done
  int planned_iterations = 0;                     // that the learning rates were made for
  std::string quality = {};                       // the bundle that render.* are; "custom": none
  std::vector<std::string> settings = {};  // "key=value" of every option, as "simuli train --set" takes them
  std::string version = {};                // of simuli
  std::string device = {};
  std::string driver = {};
  std::optional<HeldOutScores> held_out = {};  // none where none was held out, or it was not asked
};

}  // namespace simuli
