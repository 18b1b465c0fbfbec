#pragma once
// Extensions of training that depend on changes of the particle sets.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/densify.hpp"
#include "optim/base/state.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/trained_set.hpp"

namespace simuli {

struct TrainOptions;

class SetHook {
 public:
  SetHook() = default;
  SetHook(const SetHook&) = delete;
  SetHook& operator=(const SetHook&) = delete;
  virtual ~SetHook() = default;

  /// Called before the steps of an iteration.
  virtual void begin(int iteration, bool lidar_pruned) = 0;
  /// Adds to the camera set's gradients after the backward pass of a picture.
  virtual void add_gradients(const Pass& pass, int iteration) = 0;
  /// Called with the keys of all shards after their passes, so that all ranks have the same state.
  virtual void finish_shards(const Buffer<std::uint32_t>& keys, int iteration) = 0;
  /// Called after `densify` relocated particles of the camera set.
  virtual void relocate(DensifyStage& densify) = 0;
  /// Called after a set was reordered: index i now has the former order[i].
  virtual void reorder(SetNumber number, const std::vector<Eigen::Index>& order) = 0;

  virtual void report(TrainReport& report) const = 0;
  virtual void add_state(StateList& list) = 0;
};

}  // namespace simuli
