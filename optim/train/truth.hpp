#pragma once
// Recorded frames on the device, the ground truth of losses.
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/lru_cache.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "io/log/log.hpp"
#include "optim/init/sky.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

struct ImageTruth {
  RayValues truth;  // 3 channels; -1: unknown
  std::size_t known = 0;  // known pixels
};
struct SweepTruth {
  RayValues truth;  // range (-1: unknown), intensity; with rays of its own
  std::size_t known = 0;  // known rays
  std::size_t returned = 0;  // known rays with a return
};

/// The training frames of a log, read on demand and cached within a device memory budget.
class TruthCache {
 public:
  /// `log` must outlive this object. `render`: the resolved options of the renderer.
  TruthCache(const Device& device,
             const Log& log,
             const TrainingOptions& options,
             const RenderOptions& render);

  /// Returns the rays of a camera of the log, scaled by frames.image_scale.
  const SensorRays& camera_rays(const std::string& name);
  /// Returns a frame by its index into log.images or log.sweeps. Throws Error{kInput} when the file cannot be
  /// read.
  std::shared_ptr<const ImageTruth> image(std::size_t index);
  std::shared_ptr<const SweepTruth> sweep(std::size_t index);
  /// Announces the next frames in order: files that are not cached are read in the background.
  void expect(const std::vector<std::size_t>& images, const std::vector<std::size_t>& sweeps);
  /// Returns a sweep as recorded, with ranges corrected by the biases of lidar().
  [[nodiscard]] Sweep stated(std::size_t index) const;

  /// The LiDAR of the log with the learned range biases.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return lidars_.at(name); }
  /// Sets the range biases [rows] in m of a LiDAR with rows; later sweeps are corrected by them.
  void set_range_biases(const std::string& name, const std::vector<double>& biases_m);

 private:
  [[nodiscard]] ImageTruth read_image_truth(std::size_t index);
  [[nodiscard]] SweepTruth read_sweep_truth(std::size_t index) const;

  Device device_;
  const Log& log_;
  RenderOptions render_;
  std::map<std::string, Camera> models_;  // scaled, by name
  std::map<std::string, LidarModel> lidars_;
  std::map<std::string, std::unique_ptr<SensorRays>> camera_rays_;
  double image_scale_;
  SkyFinder sky_finder_;
  std::map<std::size_t, std::optional<SkyMask>> sky_;  // of pictures read so far
  std::size_t cache_bytes_;  // of each
  LruCache<ImageTruth> images_;
  LruCache<SweepTruth> sweeps_;
};

}  // namespace simuli
