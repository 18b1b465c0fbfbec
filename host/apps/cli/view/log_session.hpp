#pragma once
// A log before training: its pictures, sweeps projected into them and in space, boxes.
#include <cstddef>
#include <string>
#include <vector>

#include "host/apps/cli/view/view_answers.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {

/// Answers with each sensor's frame nearest to the requested time. Throws Error{kUsage} for requests that need
/// a scene: other poses and layers, edits; Error{kInput} for a sensor without frames.
class LogSession : public ViewAnswers {
 public:
  explicit LogSession(Log log);

  [[nodiscard]] std::string describe() const override;
  [[nodiscard]] std::string progress() const override;
  [[nodiscard]] std::string picture(const ViewRequest& request) override;
  /// Returns points of sweeps evenly spaced along the drive, at most kMostReturns, each "every"-th.
  [[nodiscard]] std::string sweep(const ViewRequest& request) override;
  /// Returns the return nearest to the pixel, within a hundredth of the width.
  [[nodiscard]] std::string probe(const ViewRequest& request) override;

  static constexpr std::size_t kMostReturns = 600'000;

 private:
  struct Points {
    std::vector<float> values;  // kPointValues each
    Pose scene_from_lidar;
    std::size_t rays = 0;
  };
  [[nodiscard]] Points points_of_sweep(const SweepFrame& frame, std::size_t every) const;
  [[nodiscard]] const SweepFrame& sweep_at(const std::string& lidar, double time_s) const;
  [[nodiscard]] const ImageFrame& image_at(const std::string& camera, double time_s) const;
  [[nodiscard]] std::vector<float> points_over(const ImageFrame& image,
                                               const Camera& camera,
                                               const std::string& lidar) const;
  [[nodiscard]] Shot in_scene(const Shot& shot) const;

  Log log_;
  Eigen::Vector3d origin_;
};

}  // namespace simuli::cli
