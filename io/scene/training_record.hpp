#pragma once
// How a scene was made: the key "training" of scene.json.
#include <optional>
#include <string>
#include <vector>

#include "io/log/frame_selection.hpp"

namespace simuli {

/// Scores of the held-out frames as in `simuli eval`. NaN without such frames.
struct HeldOutScores {
  std::size_t images = 0, sweeps = 0;  // compared frames
  int image_width = 0;                 // px, of the compared pictures
  int image_height = 0;
  double psnr_db = 0.0;
  double ssim = 0.0;
  double distance_median_m = 0.0;
  double intensity_rmse = 0.0;
  double raydrop_accuracy = 0.0;
  double chamfer_m = 0.0;
};
/// Calls field(key, value) for each score, with the keys of JSON and Python.
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

/// The data needed to repeat a training and to determine its held-out frames.
struct TrainingRecord {
  std::string log_name = {};
  std::string log_hash = {};  // io/log/log.hpp
  FrameSelection frames = {};
  std::vector<SensorUse> sensors = {};            // use of each sensor's frames; empty: unknown
  std::vector<std::string> labels_left_out = {};  // actors of the log that the training ignored
  int iterations = 0;                             // completed
  int planned_iterations = 0;                     // on which the learning rates were based
  std::string quality = {};                       // level of the render.* settings; "custom": none
  std::vector<std::string> settings = {};         // "key=value" of every option, as for "simuli train --set"
  std::string version = {};                       // of simuli
  std::string device = {};
  std::string driver = {};
  std::optional<HeldOutScores> held_out = {};  // no value without held-out frames or evaluation
};

}  // namespace simuli
