// Training and evaluation in Python.
#include <cmath>
#include <functional>
#include <pybind11/functional.h>
#include <utility>

#include "host/apps/python/bindings.hpp"

namespace simuli::python {
namespace {

py::dict dict_of(const HeldOutScores& scores) {
  py::dict out;
  visit_scores(scores, [&out](const char* key, const auto& value) { out[key] = value; });
  return out;
}

py::dict train(const std::filesystem::path& log,
               const std::filesystem::path& scene,
               const std::string& quality,
               const std::vector<std::string>& settings,
               const std::function<void(int, double)>& progress,
               const py::object& device,
               bool overwrite) {
  const TrainingOptions options = training_options(quality, settings);  // before anything is read
  const PyDevice on = device_of(device);
  std::optional<HeldOutScores> held_out;
  Eigen::Index camera_particles = 0, lidar_particles = 0;
  const TrainReport report = [&] {
    const DeviceLock lock(on.mutex);
    const SceneOutput output(scene, overwrite);
    const Log recorded = read_log(log);
    Training training(on.device, recorded, options);
    const TrainReport& done = training
                                  .run([&](const TrainStatus& status) {
                                    const py::gil_scoped_acquire acquire;
                                    if (progress) progress(status.iteration, status.psnr_db);
                                  })
                                  .train;
    const TrainReport kept = done;
    SceneFile made = std::move(training).result();
    camera_particles = made.scene.camera.size();
    lidar_particles = made.scene.lidar.size();
    held_out = write_trained_scene(scene, on.device, std::move(made), recorded, options.train.render);
    return kept;
  }();
  py::dict out;
  out["iterations"] = report.last.iteration;
  out["train_psnr_db"] = report.last.psnr_db;
  out["train_distance_m"] = report.last.distance_m;
  out["train_drop_accuracy"] = report.last.drop_accuracy;
  out["camera_particles"] = camera_particles;
  out["lidar_particles"] = lidar_particles;
  out["seconds"] = report.seconds;
  out["warnings"] = report.warnings;
  out["held_out"] = held_out ? py::object(dict_of(*held_out)) : py::object(py::none());
  return out;
}

/// None for a share of nothing.
py::object share(double value) {
  return std::isfinite(value) ? py::object(py::float_(value)) : py::object(py::none());
}

void put_scores(py::dict& out, const EvalScores& r) {
  out["images"] = r.images;
  out["sweeps"] = r.sweeps;
  out["psnr_db"] = r.psnr_db;
  out["ssim"] = r.ssim;
  out["flip"] = r.flip;
  out["psnr_corrected_db"] = r.psnr_corrected_db;
  out["distance_median_m"] = r.lidar.distance_median_m;
  out["distance_expected_median_m"] = r.distance_expected_median_m;
  out["share_own"] = r.share_own;
  out["medl2_m2"] = r.lidar.medl2_m2;
  out["mean_rel_l2"] = r.lidar.mean_rel_l2;
  out["intensity_rmse"] = r.lidar.intensity_rmse;
  out["raydrop_accuracy"] = r.lidar.raydrop_accuracy;
  out["raydrop_trivial"] = r.lidar.raydrop_trivial;
  out["drop_recall"] = share(r.lidar.drop_recall);
  out["drop_precision"] = share(r.lidar.drop_precision);
  out["chamfer_m2"] = r.lidar.chamfer_m2;
  out["chamfer_m"] = r.lidar.chamfer_m;
  out["actor_psnr_db"] = r.actor_psnr_db;
  out["actor_distance_median_m"] = r.actor_distance_median_m;
  out["actor_share_met"] = r.actor_share_met;
  py::list ranges, kinds;
  for (std::size_t i = 0; i < r.ranges.size(); ++i) {
    const RangeScores& s = r.ranges[i];
    py::dict range;
    range["from_m"] = RangeScores::kFrom_m[i];
    range["returns"] = s.returns;
    range["distance_median_m"] = s.distance_median_m;
    range["distance_mean_m"] = s.distance_mean_m;
    range["share_dropped"] = s.share_dropped;
    range["returns_of_nothing"] = s.returns_of_nothing;
    range["pixels"] = s.pixels;
    range["psnr_db"] = s.psnr_db;
    ranges.append(range);
  }
  for (const KindScores& s : r.kinds) {
    py::dict kind;
    kind["kind"] = s.kind;
    kind["pixels"] = s.pixels;
    kind["psnr_db"] = s.psnr_db;
    kind["returns"] = s.returns;
    kind["distance_median_m"] = s.distance_median_m;
    kind["share_met"] = s.share_met;
    kinds.append(kind);
  }
  out["ranges"] = ranges;
  out["kinds"] = kinds;
}

py::dict evaluate(const std::filesystem::path& scene,
                  const std::filesystem::path& log,
                  const std::string& quality,
                  const std::vector<std::string>& settings,
                  const py::object& device) {
  const EvalOptions options = eval_options(quality, settings);
  const PyDevice on = device_of(device);
  const EvalReport r = [&] {
    const DeviceLock lock(on.mutex);
    return Evaluation(on.device, read_scene(scene), read_log(log), options).run();
  }();
  py::dict out;
  out["frames"] = to_string(r.frames.kind);
  out["held_out_every"] = r.frames.asked.held_out_every;
  out["held_out_middle"] = r.frames.asked.held_out_middle;
  out["held_out_last"] = r.frames.asked.held_out_last;
  out["held_out_sensors"] = r.frames.asked.held_out_sensors;
  out["image_scale"] = r.frames.asked.image_scale;
  put_scores(out, r);
  out["warnings"] = r.warnings;
  const auto part = [](const std::optional<EvalScores>& scores) -> py::object {
    if (!scores) return py::none();
    py::dict of_part;
    put_scores(of_part, *scores);
    return of_part;
  };
  out["between"] = part(r.between);
  out["middle"] = part(r.middle);
  out["beyond"] = part(r.beyond);
  out["sensor"] = part(r.sensor);
  py::dict sensors;
  for (const auto& [sensor, scores] : r.by_sensor) sensors[sensor.c_str()] = part(scores);
  out["by_sensor"] = sensors;
  return out;
}

}  // namespace

void add_training(py::module_& m) {
  m.def(
      "train",
      &train,
      py::arg("log"),
      py::arg("scene"),
      py::arg("quality") = "",
      py::arg("settings") = std::vector<std::string>{},
      py::arg("progress") = nullptr,
      py::arg("device") = py::none(),
      py::arg("overwrite") = false,
      "A scene from a log folder, as `simuli train` makes it, bit for bit. settings: \"key=value\", as "
      "`simuli train --set help` lists them; progress(iteration, psnr_db) is called after each iteration. "
      "The dict tells particles, training scores, and under held_out those of the frames that were held out "
      "(None: there were none). simuli.Error, before the training, when there is something at `scene`; "
      "overwrite replaces a scene.");
  m.def("evaluate",
        &evaluate,
        py::arg("scene"),
        py::arg("log"),
        py::arg("quality") = "",
        py::arg("settings") = std::vector<std::string>{},
        py::arg("device") = py::none(),
        "What `simuli eval SCENE LOG` says, by the names of its --json; NaN where there is no such frame, "
        "drop_recall and drop_precision None where no ray drops or is said to.");
}

}  // namespace simuli::python
