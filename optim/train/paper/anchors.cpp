#include "optim/train/paper/anchors.hpp"

#include "optim/train/paper/anchor_stage.hpp"
#include "optim/train/train_options.hpp"

namespace simuli {
namespace {

// Iterations between searches for candidates, and between choices of the nearest candidate.
constexpr int kSearchEvery = 1000, kChooseEvery = 10;

class Anchors final : public SetHook {
 public:
  Anchors(const Device& device, double weight, TrainedSet& camera, TrainedSet& lidar)
      : weight_(weight),
        camera_(camera),
        lidar_(lidar),
        stage_(device, Precision::kFloat, kAnchorNeighbours) {}

  void begin(int iteration, bool lidar_pruned) override {
    if (iteration % kSearchEvery != 0 && !lidar_pruned) return;
    stage_.assign(camera_.particles, lidar_.particles, kAnchorReach_m);
  }

  void add_gradients(const Pass& pass, int iteration) override {
    // The mean is over all particles; particles outside the frame take no step and need no gradient.
    add(pass.buffers().projected.keys, weight_ / camera_.particles.count, iteration);
  }

  void finish_shards(const Buffer<std::uint32_t>& keys, int iteration) override {
    // The gradients have been consumed: weight 0 only updates the choices.
    add(keys, 0.0, iteration);
  }

  void relocate(DensifyStage& densify) override {
    densify.follow(stage_.candidates(), stage_.neighbours());
    densify.follow(stage_.nearest(), 1);
  }

  void reorder(SetNumber number, const std::vector<Eigen::Index>& order) override {
    if (number == kCameraSet)
      stage_.follow_set(order);
    else
      stage_.follow_targets(order);
  }

  void report(TrainReport& report) const override { report.anchor_m = stage_.loss().mean_m(); }

  void add_state(StateList& list) override {
    list.add("anchor/candidates", stage_.candidates());
    list.add("anchor/nearest", stage_.nearest());
  }

 private:
  void add(const Buffer<std::uint32_t>& keys, double weight, int iteration) {
    stage_.add_gradient(
        camera_.particles, lidar_.particles, keys, weight, iteration % kChooseEvery == 0, camera_.grads);
  }

  double weight_;
  TrainedSet &camera_, &lidar_;
  AnchorStage stage_;
};

bool has_anchors(const TrainOptions& options, std::uint64_t camera_particles, std::uint64_t lidar_particles) {
  return options.anchor.weight > 0.0 && camera_particles > 0 && lidar_particles > 0;
}

}  // namespace

std::unique_ptr<SetHook> make_anchors(const Device& device,
                                      const TrainOptions& options,
                                      TrainedSet& camera,
                                      TrainedSet& lidar) {
  if (!has_anchors(options, camera.particles.count, lidar.particles.count)) return nullptr;
  return std::make_unique<Anchors>(device, options.anchor.weight, camera, lidar);
}

std::vector<BufferBytes> anchor_bytes(const Device& device,
                                      const TrainOptions& options,
                                      std::uint64_t camera_particles,
                                      std::uint64_t lidar_particles) {
  if (!has_anchors(options, camera_particles, lidar_particles)) return {};
  return AnchorBuffers(device).bytes({camera_particles,
                                      kAnchorNeighbours,
                                      lidar_particles,
                                      chunks_of(device, lidar_particles).work_items,
                                      chunks_of(device, camera_particles).work_items});
}

}  // namespace simuli
