// Training and evaluation in Python.
#include <cmath>
#include <functional>
#include <pybind11/functional.h>
#include <string_view>
#include <type_traits>
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
  const TrainingOptions options = training_options(quality, settings);  // throws before any file is read
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

/// Puts reports and scores into a dict. NaN is kept, except for recall and precision without dropped rays: None.
struct DictScores {
  py::dict out;

  template <class Value>
  void operator()(const char* key, const Value& value) {
    out[key] = value;
  }
  void operator()(const char* key, double value) {
    const std::string_view name = key;
    const bool is_share = name == "drop_recall" || name == "drop_precision";
    out[key] = is_share && std::isnan(value) ? py::object(py::none()) : py::object(py::float_(value));
  }
  template <class Scores>
  requires std::is_base_of_v<FrameScore, Scores> || std::is_same_v<KindScores, Scores>
  void operator()(const char* key, const std::vector<Scores>& all) {
    py::list list;
    for (const Scores& scores : all) list.append(of(scores));
    out[key] = list;
  }
  void operator()(const char* key, const std::vector<RangeScores>& ranges) {
    py::list list;
    for (std::size_t i = 0; i < ranges.size(); ++i) list.append(of(ranges[i], i));
    out[key] = list;
  }
  void operator()(const char* key, const std::optional<EvalScores>& scores) {
    out[key] = scores ? py::object(of(*scores)) : py::object(py::none());
  }
  void operator()(const char* key, const std::vector<std::pair<std::string, EvalScores>>& by_name) {
    py::dict all;
    for (const auto& [name, scores] : by_name) all[name.c_str()] = of(scores);
    out[key] = all;
  }

  template <class Scores, class... Index>
  static py::dict of(const Scores& scores, Index... index) {
    DictScores inner;
    visit_scores(scores, index..., inner);
    return inner.out;
  }
};

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
  DictScores report;
  visit_report(r, report);
  return report.out;
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
      "Trains a scene from a log folder, with the same bits as `simuli train`. settings: \"key=value\", as "
      "`simuli train --set help` lists them; progress(iteration, psnr_db) is called after each iteration. "
      "Returns particle counts, training scores, and under held_out the scores of the held-out frames (None "
      "without any). Throws simuli.Error before the training if `scene` exists; overwrite replaces a scene.");
  m.def("evaluate",
        &evaluate,
        py::arg("scene"),
        py::arg("log"),
        py::arg("quality") = "",
        py::arg("settings") = std::vector<std::string>{},
        py::arg("device") = py::none(),
        "Returns the scores that `simuli eval SCENE LOG --json` prints, by the same keys; NaN without such "
        "frames, "
        "drop_recall and drop_precision None without dropped rays.");
}

}  // namespace simuli::python
