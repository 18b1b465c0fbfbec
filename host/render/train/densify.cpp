// Launcher of "kernels/densify.cl".
#include "host/render/train/densify.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <utility>
#include <vector>

#include "host/base/error.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 64;
// Whole-number weights add up to less than 2^32, whatever rounding does to each.
constexpr double kShares = 4294967296.0 * (1.0 - 1e-6);

Program program(const Device& device, Precision precision) {
  BuildOptions options;
  return {device, "kernels/densify.cl", options.real(precision)};
}

std::uint32_t low_word(std::uint64_t x) { return static_cast<std::uint32_t>(x & 0xffffffffU); }
std::uint32_t high_word(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32U); }

}  // namespace

DensifyStage::DensifyStage(const Device& device, Precision precision)
    : device_(device),
      precision_(precision),
      scan_(device),
      weights_(device, "error weights", precision),
      sums_(device, "error sums", precision),
      dead_(device, "dead particles"),
      share_(device, "shares"),
      targets_(device, "relocated"),
      source_(device, "sources"),
      copies_(device, "copies"),
      pixel_error_(program(device, precision), "pixel_error"),
      beam_error_(program(device, precision), "beam_error"),
      accumulate_(program(device, precision), "accumulate_error"),
      weigh_(program(device, precision), "weigh_particles"),
      list_(program(device, precision), "list_dead"),
      draw_(program(device, precision), "draw_sources"),
      copy_(program(device, precision), "copy_particles"),
      clear_(program(device, precision), "clear_moments"),
      copy_words_(program(device, precision), "copy_words"),
      widen_(program(device, precision), "widen_rows"),
      jitter_(program(device, precision), "jitter_means") {}

void DensifyStage::pixel_error(const shared::FrameParams& frame,
                               const FrameBuffers& buffers,
                               const RealBuffer& picture,
                               const RealBuffer& truth,
                               RealBuffer& ray_error) {
  ray_error.reserve(frame.slots);
  pixel_error_.launch(frame.slots, kLocalSize, frame.slots, buffers.world_ray, picture, truth, ray_error);
}

void DensifyStage::beam_error(const shared::FrameParams& frame,
                              const FrameBuffers& buffers,
                              const RealBuffer& truth,
                              const std::array<double, 3>& weights,
                              RealBuffer& ray_error) {
  ray_error.reserve(frame.slots);
  weights_.assign(std::span<const double>(weights));
  beam_error_.launch(
      frame.slots, kLocalSize, frame.slots, weights_, buffers.world_ray, buffers.out, truth, ray_error);
}

void DensifyStage::accumulate(const shared::FrameParams& frame,
                              const FrameBuffers& buffers,
                              RealBuffer& accumulated) {
  accumulate_.launch(round_up(frame.particles, kLocalSize),
                     kLocalSize,
                     frame.particles,
                     buffers.keys,
                     buffers.footprints,
                     buffers.emission,
                     buffers.instance_error,
                     accumulated);
}

void DensifyStage::widen(
    RealBuffer& rows, std::uint32_t count, std::uint32_t stride, std::uint32_t new_stride, bool params) {
  const std::size_t row_count = rows.count() / std::max(stride, 1U);
  RealBuffer wide(device_, rows.name(), precision_, row_count * new_stride);
  widen_.launch(round_up(new_stride, kLocalSize),
                kLocalSize,
                static_cast<std::uint32_t>(row_count),
                count,
                stride,
                new_stride,
                params ? 1U : 0U,
                rows,
                wide);
  std::swap(rows, wide);
}

DensifyCounts DensifyStage::relocate(ParticleBuffers& particles,
                                     std::span<RealBuffer* const> moments,
                                     RealBuffer& accumulated,
                                     std::uint32_t growth,
                                     const RandomKey& key) {
  changed_ = 0;
  const std::uint32_t n = particles.count;
  if (n == 0) return {};
  const auto rows = static_cast<std::uint32_t>(param_rows(particles.sh_degree));
  const Chunks chunks = chunks_of(device_, n);
  dead_.reserve(chunks.work_items);
  sums_.reserve(chunks.work_items);
  weigh_.launch(chunks.work_items,
                1,
                n,
                chunks.chunk,
                rows,
                particles.stride,
                particles.params,
                accumulated,
                dead_,
                sums_);
  const auto dead =
      static_cast<std::uint32_t>(scan_.run(dead_, static_cast<std::uint32_t>(chunks.work_items), true));
  const std::vector<double> sums = sums_.download_double();
  const double error = std::accumulate(sums.begin(), sums.end(), 0.0);
  const std::uint32_t wanted = dead + growth;
  if (!(error > 0.0) || wanted == 0) return {};
  if (std::uint64_t{n} + growth > SIM_PARTICLE_MASK) {
    throw Error(ErrorKind::kInternal, fmt::format("densify: {} + {} particles in one set", n, growth));
  }

  targets_.reserve(wanted);
  source_.reserve(wanted);
  share_.reserve(n);
  copies_.reserve(n);
  copies_.fill(0);
  list_.launch(chunks.work_items,
               1,
               n,
               chunks.chunk,
               rows,
               particles.stride,
               particles.params,
               accumulated,
               dead_,
               kShares / error,
               targets_,
               share_);
  const std::uint64_t total = scan_.run(share_, n, true);
  if (total == 0 || total > 0xffffffffU) return {};  // errors so uneven that none is worth a share
  draw_.launch(round_up(wanted, kLocalSize),
               kLocalSize,
               wanted,
               dead,
               n,
               n,
               static_cast<std::uint32_t>(total),
               low_word(key.seed),
               high_word(key.seed),
               key.iteration,
               key.set,
               share_,
               targets_,
               source_,
               copies_);

  if (growth > 0) {
    const auto stride = static_cast<std::uint32_t>(round_up(n + growth, 16));
    for (RealBuffer* moment : moments) widen(*moment, n, particles.stride, stride, false);
    widen(particles.params, n, particles.stride, stride, true);
    particles.count = n + growth;
    particles.stride = stride;
    accumulated.reserve(particles.count);
  }
  const auto copy = [&](std::uint32_t count, bool in_place) {
    copy_.launch(round_up(count, kLocalSize),
                 kLocalSize,
                 count,
                 rows,
                 particles.stride,
                 in_place ? 1U : 0U,
                 targets_,
                 source_,
                 copies_,
                 particles.params);
  };
  copy(wanted, false);
  copy(n, true);
  for (RealBuffer* moment : moments) {
    clear_.launch(round_up(std::max(wanted, n), kLocalSize),
                  kLocalSize,
                  wanted,
                  n,
                  rows,
                  particles.stride,
                  targets_,
                  copies_,
                  *moment);
  }
  accumulated.fill(0.0);
  changed_ = wanted;
  particles_ = particles.count;
  if (particles.actors > 0) {
    follow(particles.actor_of, 1);
    particles.refresh_actors();
  }
  return {dead, growth};
}

void DensifyStage::follow(Buffer<std::uint32_t>& words, std::uint32_t width) {
  if (changed_ == 0) return;
  words.extend(std::size_t{particles_} * width);
  copy_words_.launch(round_up(changed_, kLocalSize), kLocalSize, changed_, width, targets_, source_, words);
}

void DensifyStage::jitter(ParticleBuffers& particles,
                          const Buffer<std::uint32_t>& keys,
                          double strength,
                          const RandomKey& key) {
  jitter_.launch(round_up(particles.count, kLocalSize),
                 kLocalSize,
                 particles.count,
                 particles.stride,
                 strength,
                 low_word(key.seed),
                 high_word(key.seed),
                 key.iteration,
                 key.set,
                 keys,
                 particles.params);
}

}  // namespace simuli
