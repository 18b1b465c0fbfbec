// Launcher of "kernels/densify.cl".
#include "host/device/render/train/densify.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

// Integer weights sum to less than 2^32 with any rounding.
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
      buffers_(device, precision),
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
                               const WorldRays& world_rays,
                               const RealBuffer& picture,
                               const RealBuffer& truth,
                               RealBuffer& ray_error) {
  ray_error.reserve(frame.slots);
  pixel_error_.run_over(
      frame.slots,
      {{"slots", frame.slots}, world_rays, {"picture", picture}, {"truth", truth}, {"error", ray_error}});
}

void DensifyStage::beam_error(const shared::FrameParams& frame,
                              const WorldRays& world_rays,
                              const Blended& blended,
                              const RealBuffer& truth,
                              const std::array<double, 3>& weights,
                              RealBuffer& ray_error) {
  ray_error.reserve(frame.slots);
  buffers_.weights.assign(std::span<const double>(weights));
  beam_error_.run_over(frame.slots,
                       {{"slots", frame.slots},
                        {"weight", buffers_.weights},
                        world_rays,
                        blended,
                        {"truth", truth},
                        {"error", ray_error}});
}

void DensifyStage::accumulate(const shared::FrameParams& frame,
                              const FrameBuffers& made,
                              const GradientBuffers& gradients,
                              RealBuffer& accumulated) {
  accumulate_.run_over(
      frame.particles,
      {{"n", frame.particles}, made.projected, made.binned, gradients, {"accumulated", accumulated}});
}

void DensifyStage::widen(
    RealBuffer& rows, std::uint32_t count, std::uint32_t stride, std::uint32_t new_stride, bool params) {
  const std::size_t row_count = rows.count() / std::max(stride, 1U);
  RealBuffer wide(device_, rows.name(), precision_, row_count * new_stride);
  widen_.run_over(new_stride,
                  {{"rows", static_cast<std::uint32_t>(row_count)},
                   {"n", count},
                   {"stride", stride},
                   {"new_stride", new_stride},
                   {"is_params", params ? 1U : 0U},
                   {"from", rows},
                   {"to", wide}});
  rows.exchange(wide);
}

DensifyStage::Census DensifyStage::census(const ParticleBuffers& particles, const RealBuffer& accumulated) {
  Census out{chunks_of(device_, particles.count)};
  buffers_.dead.reserve(out.chunks.work_items);
  buffers_.sums.reserve(out.chunks.work_items);
  weigh_.run(out.chunks.work_items,
             out.chunks.group,
             {{"n", particles.count},
              {"chunk", out.chunks.chunk},
              {"rows", static_cast<std::uint32_t>(param_rows(particles.sh_degree))},
              {"stride", particles.stride},
              {"params", particles.params},
              {"accumulated", accumulated},
              {"dead", buffers_.dead},
              {"sums", buffers_.sums}});
  out.dead = static_cast<std::uint32_t>(
      scan_.run(buffers_.dead, static_cast<std::uint32_t>(out.chunks.work_items), true));
  const std::vector<double> sums = buffers_.sums.download_double();
  out.error = std::accumulate(sums.begin(), sums.end(), 0.0);
  return out;
}

bool DensifyStage::draw(const ParticleBuffers& particles,
                        const RealBuffer& accumulated,
                        const Census& census,
                        std::uint32_t growth,
                        const RandomKey& key) {
  const std::uint32_t n = particles.count, wanted = census.dead + growth;
  buffers_.reserve({n, wanted, census.chunks.work_items});
  buffers_.copies.fill(0);
  list_.run(census.chunks.work_items,
            census.chunks.group,
            {{"n", n},
             {"chunk", census.chunks.chunk},
             {"rows", static_cast<std::uint32_t>(param_rows(particles.sh_degree))},
             {"stride", particles.stride},
             {"params", particles.params},
             {"accumulated", accumulated},
             {"dead_before", buffers_.dead},
             {"scale", kShares / census.error},
             {"targets", buffers_.targets},
             {"share", buffers_.share}});
  const std::uint64_t total = scan_.run(buffers_.share, n, true);
  if (total == 0 || total > 0xffffffffU) return false;
  draw_.run_over(wanted,
                 {{"count", wanted},
                  {"listed", census.dead},
                  {"first_new", n},
                  {"n", n},
                  {"total", static_cast<std::uint32_t>(total)},
                  {"seed_low", low_word(key.seed)},
                  {"seed_high", high_word(key.seed)},
                  {"iteration", key.iteration},
                  {"set", key.set},
                  {"running", buffers_.share},
                  {"targets", buffers_.targets},
                  {"source", buffers_.source},
                  {"copies", buffers_.copies}});
  return true;
}

void DensifyStage::grow(ParticleBuffers& particles,
                        std::span<RealBuffer* const> moments,
                        std::uint32_t growth) {
  const std::uint32_t n = particles.count;
  const auto stride = static_cast<std::uint32_t>(round_up(n + growth, 16));
  for (RealBuffer* moment : moments) widen(*moment, n, particles.stride, stride, false);
  widen(particles.params, n, particles.stride, stride, true);
  particles.count = n + growth;
  particles.stride = stride;
}

void DensifyStage::copy(ParticleBuffers& particles,
                        std::span<RealBuffer* const> moments,
                        std::uint32_t before) {
  const auto rows = static_cast<std::uint32_t>(param_rows(particles.sh_degree));
  const auto wanted = static_cast<std::uint32_t>(buffers_.targets.count());
  for (const bool in_place : {false, true}) {
    const std::uint32_t count = in_place ? before : wanted;
    copy_.run_over(count,
                   {{"count", count},
                    {"rows", rows},
                    {"stride", particles.stride},
                    {"in_place", in_place ? 1U : 0U},
                    {"targets", buffers_.targets},
                    {"source", buffers_.source},
                    {"copies", buffers_.copies},
                    {"params", particles.params}});
  }
  for (RealBuffer* moment : moments) {
    clear_.run_over(std::max(wanted, before),
                    {{"count", wanted},
                     {"n", before},
                     {"rows", rows},
                     {"stride", particles.stride},
                     {"targets", buffers_.targets},
                     {"copies", buffers_.copies},
                     {"moments", *moment}});
  }
}

DensifyCounts DensifyStage::relocate(ParticleBuffers& particles,
                                     std::span<RealBuffer* const> moments,
                                     RealBuffer& accumulated,
                                     std::uint32_t growth,
                                     const RandomKey& key) {
  changed_ = 0;
  const std::uint32_t n = particles.count;
  if (n == 0) return {};
  const Census found = census(particles, accumulated);
  const std::uint32_t wanted = found.dead + growth;
  if (!(found.error > 0.0) || wanted == 0) return {};
  if (std::uint64_t{n} + growth > SIM_PARTICLE_MASK) {
    throw Error(ErrorKind::kInternal, fmt::format("densify: {} + {} particles in one set", n, growth));
  }
  if (!draw(particles, accumulated, found, growth, key)) return {};
  if (growth > 0) {
    grow(particles, moments, growth);
    accumulated.reserve(particles.count);
  }
  copy(particles, moments, n);
  accumulated.fill(0.0);
  changed_ = wanted;
  particles_ = particles.count;
  if (particles.actors > 0) {
    follow(particles.actor_of, 1);
    particles.refresh_actors();
  }
  return {found.dead, growth};
}

void DensifyStage::follow(Buffer<std::uint32_t>& words, std::uint32_t width) {
  if (changed_ == 0) return;
  words.extend(std::size_t{particles_} * width);
  copy_words_.run_over(changed_,
                       {{"count", changed_},
                        {"width", width},
                        {"targets", buffers_.targets},
                        {"source", buffers_.source},
                        {"words", words}});
}

void DensifyStage::jitter(ParticleBuffers& particles,
                          const Buffer<std::uint32_t>& keys,
                          double strength,
                          const RandomKey& key) {
  jitter_.run_over(particles.count,
                   {{"n", particles.count},
                    {"stride", particles.stride},
                    {"strength", strength},
                    {"seed_low", low_word(key.seed)},
                    {"seed_high", high_word(key.seed)},
                    {"iteration", key.iteration},
                    {"set", key.set},
                    {"keys", keys},
                    {"params", particles.params}});
}

}  // namespace simuli
