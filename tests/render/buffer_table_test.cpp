// Tests that the tables of device buffers are complete: their sum is the memory of a frame, and names are
// unique.
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <string>

#include "host/device/render/backward/backward_stages.hpp"
#include "host/device/render/backward/deform_bwd.hpp"
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/rays/ray_mask.hpp"
#include "host/device/render/train/actor.hpp"
#include "host/device/render/train/adam.hpp"
#include "host/device/render/train/densify.hpp"
#include "host/device/render/train/loss_stages.hpp"
#include "optim/train/paper/anchor_stage.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

template <class Sizes>
void expect_counted(const Device& device, const BufferTable<Sizes>& table, const Sizes& sizes) {
  for (const BufferBytes& reported : table.bytes(sizes)) {
    EXPECT_EQ(device.memory_by_name().at(reported.name).now, reported.bytes) << reported.name;
  }
}

TEST(BufferTable, TellsWhatAFrameTakes) {
  for (const test::SceneCase& scene : {test::kCameraStill, test::kLidarMoving}) {
    SCOPED_TRACE(scene.name);
    const Device& device = test::device();
    const test::Shot shot = test::shot_of(scene, 72, 40);
    Renderer renderer(device, {});
    const GaussianSet set = test::set_for(scene, {.count = 200, .low = {-8, -8, -3}, .high = {8, 8, 3}}, 5);
    const ParticleBuffers particles(device, set, Precision::kFloat);
    const SensorRays rays = shot.on(device, {});
    const Pass pass = renderer.render(particles, rays, shot.view);
    const FrameBuffers& made = pass.buffers();
    const shared::FrameParams& frame = pass.frame();
    const FrameSizes sizes{
        .particles = frame.particles,
        .stride = frame.stride,
        .visible = made.binned.visible,
        .pairs = made.binned.pairs,
        .slots = frame.slots,
        .tiles = std::uint64_t{frame.tiles_x} * frame.tiles_y,
        .ray_rows = scene.moving ? 6U : 3U,
        .outputs = static_cast<std::uint64_t>(scene.kind == SetKind::kLidar ? SIM_OUTPUTS : SIM_O_DROP)};
    ASSERT_GT(sizes.pairs, sizes.visible);
    expect_counted(device, made.rays, sizes);
    expect_counted(device, made.projected, sizes);
    expect_counted(device, made.binned, sizes);
    expect_counted(device, made.blended, sizes);
    expect_counted(device, particles, ParticleSizes::of(200, scene.sh_degree, 0));
  }
}

TEST(BufferTable, KeepsItsMembersWhenItMoves) {
  const Device& device = test::device();
  Projected first(device);
  Projected second(std::move(first));
  second.reserve({.particles = 7});
  EXPECT_EQ(second.keys.count(), 7U);
  EXPECT_EQ(second.records.count(), 7U * SIM_RECORD);
}

TEST(BufferTable, NamesAreUnique) {
  const Device& device = test::device();
  std::map<std::string, int> times;
  const auto add = [&](const auto& table) {
    for (const BufferBytes& buffer : table.bytes({})) ++times[buffer.name];
  };
  add(ActorBuffers(device));
  add(AdamBuffers(device));
  add(AnchorBuffers(device));
  add(BinScratch(device));
  add(Binned(device));
  add(Blended(device));
  add(ColorGridScratch(device));
  add(DeformBuffers(device));
  add(DensifyBuffers(device));
  add(EnvironmentScratch(device));
  add(FrameConstants(device));
  add(GradientBuffers(device));
  add(ImageLossBuffers(device));
  add(LidarLossBuffers(device));
  add(ParticleBuffers(device, GaussianSet(SetKind::kCamera, 0, 0), Precision::kFloat));
  add(PictureBuffers(device));
  add(Projected(device));
  add(RayLayout(device));
  add(RayMaskScratch(device));
  add(RequestedRays(device));
  add(SampleBuffers(device));
  add(ScanBuffers(device));
  add(SortBuffers(device));
  add(SsimBuffers(device));
  add(WorldRays(device));
  EXPECT_GT(times.size(), 70U);
  for (const auto& [name, n] : times) EXPECT_EQ(n, 1) << name;
}

}  // namespace
}  // namespace simuli
