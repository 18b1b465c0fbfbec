#pragma once
// What frames recorded, on the device: what the losses compare with.
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
  RayValues truth;        // 3 channels, -1: not known
  std::size_t known = 0;  // pixels
};
struct SweepTruth {
  RayValues truth;           // range (-1: not known), intensity; of rays of its own
  std::size_t known = 0;     // rays
  std::size_t returned = 0;  // known ones
};

/// The training frames of a log, read when they are asked for and kept within a budget of device memory.
class TruthCache {
 public:
  /// `log` must outlive it. `render`: the renderer's (resolved) options.
  TruthCache(const Device& device,
             const Log& log,
             const TrainingOptions& options,
             const RenderOptions& render);

  /// Rays of a camera of the log, scaled as frames.image_scale says.
  const SensorRays& camera_rays(const std::string& name);
  /// Index into log.images or log.sweeps. Error{kInput} when the file can't be read.
  std::shared_ptr<const ImageTruth> image(std::size_t index);
  std::shared_ptr<const SweepTruth> sweep(std::size_t index);
  /// Says that these are asked for next, in this order: files of what is not kept are read meanwhile.
  void expect(const std::vector<std::size_t>& images, const std::vector<std::size_t>& sweeps);
  /// A sweep as its file states it, its ranges corrected by the biases of lidar().
  [[nodiscard]] Sweep stated(std::size_t index) const;

  /// The LiDAR of the log, with the range biases that training has found.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return lidars_.at(name); }
  /// From now on sweeps of this LiDAR, one of rows, are corrected by these biases: [rows] m.
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
  std::map<std::size_t, std::optional<SkyMask>> sky_;  // of pictures that have been read
  std::size_t cache_bytes_;                            // of each
  LruCache<ImageTruth> images_;
  LruCache<SweepTruth> sweeps_;
};

}  // namespace simuli
