#pragma once
// Changes of the particle sets during training: relocation, growth, jitter.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/densify.hpp"
#include "optim/base/state.hpp"
#include "optim/train/set_hook.hpp"
#include "optim/train/train_options.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/trained_set.hpp"

namespace simuli {

/// Returns the iterations in which each picture is used once; without pictures each sweep.
[[nodiscard]] std::size_t epoch_of(const TrainOptions& options, std::size_t images, std::size_t sweeps);

class Structure {
 public:
  /// Returns the iterations between densifications; `epoch` as in epoch_of().
  [[nodiscard]] static int densify_every(const DensifyOptions& options, std::size_t epoch);

  /// All arguments must outlive this object; `seed` of the random numbers.
  Structure(const Device& device,
            const TrainOptions& options,
            std::size_t epoch,
            std::uint64_t seed,
            TrainedSet& camera,
            TrainedSet& lidar);

  /// Whether frames of this iteration accumulate reconstruction errors of the set.
  [[nodiscard]] bool collects_errors(SetNumber number, int iteration) const;
  /// The stage that accumulates errors; exists when collects_errors().
  [[nodiscard]] DensifyStage& errors() { return *densify_; }

  /// The extension of this training; null without one.
  [[nodiscard]] SetHook* hook() { return hook_.get(); }
  /// Adds random offsets to the particles visible in the frame of `keys`.
  void jitter(TrainedSet& set,
              SetNumber number,
              const LearningRates& rates,
              const Buffer<std::uint32_t>& keys,
              int iteration,
              double progress);
  /// Densifies when due; call it after the steps of `iteration`.
  void densify(int iteration);

  void report(TrainReport& report) const;
  void add_state(StateList& list);

 private:
  [[nodiscard]] std::uint32_t growth(SetNumber number) const;

  const TrainOptions& options_;
  int densify_every_;  // iterations
  std::uint64_t seed_;
  TrainedSet &camera_, &lidar_;
  double camera_start_, lidar_start_;  // initial particles
  std::unique_ptr<SetHook> hook_;
  std::optional<DensifyStage> densify_;  // only with densification
  std::uint64_t relocated_ = 0, grown_ = 0;
};

}  // namespace simuli
