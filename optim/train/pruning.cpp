#include "optim/train/pruning.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "optim/base/frames.hpp"
#include "optim/data/row_offsets.hpp"

namespace simuli {

bool is_prune_turn(const TrainerState& state) {
  const int iteration = state.status.iteration;
  const PruneOptions& o = state.options.prune;
  if (!(o.weight > 0.0) || iteration < o.first) return false;
  if (state.sweeps.empty() || state.lidar.particles.count == 0) return false;
  for (int k = 1; k <= o.times; ++k) {
    if (iteration == static_cast<int>(o.last_share * state.options.iterations * k / o.times)) return true;
  }
  return false;
}

void prune(TrainerState& state) {
  Buffer<std::uint32_t> largest(state.device, "largest weights", state.lidar.particles.count);
  largest.fill(0);
  std::map<std::string, RowOffsets> offsets;
  if (state.options.prune.row_ranges) {
    for (const LogLidar& lidar : state.log.lidars) {
      const auto* const rows = std::get_if<Lidar>(&lidar.model);
      if (rows != nullptr) offsets.emplace(rows->name, RowOffsets(rows->rows.size()));
    }
  }
  for (const std::size_t index : state.sweeps.frames()) {
    const SweepFrame& frame = state.log.sweeps[index];
    Pass pass = state.renderer.render(state.lidar.particles,
                                      state.truth.sweep(index)->truth.rays(),
                                      view_of(state.log, state.scene, frame));
    pass.raise_largest_weights(largest);
    const auto row = offsets.find(frame.lidar);
    if (row != offsets.end()) row->second.add(state.truth.stated(index), pass.results());
  }
  for (const auto& [name, found] : offsets) {
    std::vector<double> biases_m = found.offsets();
    // Sweeps are read again only after their biases have changed.
    if (std::all_of(biases_m.begin(), biases_m.end(), [](double b) { return b == 0.0; })) continue;
    const std::vector<LidarRow>& rows = std::get<Lidar>(state.truth.lidar(name)).rows;
    for (std::size_t row = 0; row < rows.size(); ++row) biases_m[row] += rows[row].range_bias;
    state.truth.set_range_biases(name, biases_m);
  }
  const std::vector<std::uint32_t> bits = largest.download();
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const auto weight = static_cast<double>(std::bit_cast<float>(bits[i]));
    if (weight >= state.options.prune.weight) kept.push_back(static_cast<Eigen::Index>(i));
  }
  state.pruned += state.lidar.particles.count - kept.size();
  state.lidar.keep(kept);
}

}  // namespace simuli
