#include "host/device/render/pages/particle_pages.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kNowhere = 0xffffffffU;

/// Number of particles including levels of detail, estimated before the upload generates them.
std::uint64_t particles_of(const GaussianSet& set, const RenderOptions& options) {
  const auto count = static_cast<std::uint64_t>(set.size());
  return options.detail > 0.0 ? count + count / 2 : count;
}

struct ParticleBytes {
  std::uint64_t largest = 0;
  std::uint64_t all = 0;
};

/// Bytes per particle on the device, in the largest buffer and including frame buffers by particle.
ParticleBytes bytes_of(const GaussianSet& set, const RenderOptions& options) {
  const KeptParticles kept = KeptParticles::of(set, options);
  const std::uint64_t real = options.precision == Precision::kDouble ? 8 : 4;
  ParticleBytes out;
  const std::uint64_t params = real * kept.full_rows() + 2 * (kept.rows() - kept.full_rows());
  const std::uint64_t record = real * SIM_RECORD;
  out.largest = std::max(params, record);
  out.all = params + record + sizeof(shared::Footprint) + 4;
  if (options.detail > 0.0) out.all += real * SIM_DETAIL;
  if (!set.actor.empty()) out.all += 8 + real * SIM_MOTION;
  return out;
}

std::uint32_t pages_of(std::uint64_t particles) {
  return static_cast<std::uint32_t>((particles + kPageParticles - 1) / kPageParticles);
}

struct WaitAtLast {
  const Device& device;
  ~WaitAtLast() {
    try {
      device.finish();
    } catch (const Error&) {
      // The next wait for the device reports the failure.
    }
  }
};

}  // namespace

std::uint32_t page_count(const GaussianSet& set, const RenderOptions& options) {
  return pages_of(particles_of(set, options));
}

std::uint32_t pages_that_fit(const Device& device, const GaussianSet& set, const RenderOptions& options) {
  const ParticleBytes each = bytes_of(set, options);
  const DeviceInfo& info = device.info();
  const std::uint64_t requested = static_cast<std::uint64_t>(options.particle_memory_mb) << 20U;
  const std::uint64_t bytes = requested > 0 ? requested : info.global_bytes / 3;
  const std::uint64_t particles =
      std::min({bytes / each.all, info.max_alloc_bytes / each.largest, std::uint64_t{SIM_PARTICLE_MASK}});
  return std::min(static_cast<std::uint32_t>(particles / kPageParticles), page_count(set, options));
}

ParticlePages::ParticlePages(const Device& device,
                             std::shared_ptr<const GaussianSet> set,
                             const RenderOptions& options,
                             std::uint32_t places)
    : set_(std::move(set)), buffers_(device, GaussianSet(set_->kind, 0, 0), options.precision) {
  if (options.detail > 0.0) levels_ = detail_levels(*set_);
  const GaussianSet& all = source();
  kept_ = KeptParticles::of(all, options);
  clusters_ = clusters_of(all, levels_ ? &*levels_ : nullptr);
  const std::uint32_t pages = pages_of(static_cast<std::uint64_t>(all.size()));
  const auto clusters = static_cast<std::uint32_t>((all.size() + SIM_CLUSTER - 1) / SIM_CLUSTER);
  places = std::min(places, std::max(pages, 1U));
  if (places == 0 || std::uint64_t{places} * kPageParticles > SIM_PARTICLE_MASK) {
    throw Error(ErrorKind::kUsage,
                fmt::format("render.particle_memory_mb: found room for {} particles, allowed {} to {}",
                            std::uint64_t{places} * kPageParticles,
                            kPageParticles,
                            SIM_PARTICLE_MASK));
  }
  for (std::uint32_t page = 0; page < pages; ++page) {
    first_bounds_.push_back(static_cast<std::uint32_t>(bounds_.size()));
    const std::uint32_t first = page * kPageClusters, last = std::min(first + kPageClusters, clusters);
    const auto actor = clusters_.actor.begin();
    const bool of_one = std::all_of(
        actor + first, actor + last, [&](std::uint32_t a) { return a == clusters_.actor[first]; });
    for (std::uint32_t cluster = first; cluster < last; ++cluster) {
      const ParticleBounds bounds = ParticleBounds::of(clusters_, cluster);
      if (of_one && cluster > first) {
        bounds_.back().include(bounds);
      } else {
        bounds_.push_back(bounds);
      }
    }
  }
  first_bounds_.push_back(static_cast<std::uint32_t>(bounds_.size()));

  ParticleBuffers& b = buffers_;
  b.paged = true;
  b.sh_degree = kept_.sh_degree;
  b.sh_storage = kept_.sh_storage;
  b.count = b.stride = places * kPageParticles;
  if (!all.actor.empty()) b.actors = *std::max_element(all.actor.begin(), all.actor.end());
  const std::size_t halves = kept_.rows() - kept_.full_rows();
  b.params.reserve(kept_.full_rows() * b.stride + halves * b.stride / 2);
  if (levels_) b.detail.reserve(std::size_t{SIM_DETAIL} * b.stride);
  if (b.actors > 0) b.actor_of.reserve(b.stride);
  place_of_.assign(pages, kNowhere);
  page_at_.assign(places, kNowhere);
  used_.assign(places, 0);
}

bool ParticlePages::in_sight(const FrameSight& sight, std::uint32_t page) const {
  const auto first = bounds_.begin() + first_bounds_[page], last = bounds_.begin() + first_bounds_[page + 1];
  return std::any_of(first, last, [&](const ParticleBounds& bounds) { return sight.may_see(bounds); });
}

void ParticlePages::bring(const FrameSight& sight) {
  ++frame_;
  brought_ = 0;
  std::vector<std::uint32_t> seen;
  for (std::uint32_t page = 0; page < pages(); ++page) {
    if (in_sight(sight, page)) seen.push_back(page);
  }
  if (seen.size() > places()) {
    throw Error(ErrorKind::kDevice,
                fmt::format("render.particle_memory_mb: found {} particles that a frame may see, allowed {}; "
                            "with render.detail above 0 they are fewer",
                            seen.size() * kPageParticles,
                            std::uint64_t{places()} * kPageParticles));
  }
  std::vector<std::uint32_t> missing;
  for (const std::uint32_t page : seen) {
    if (place_of_[page] == kNowhere) {
      missing.push_back(page);
    } else {
      used_[place_of_[page]] = frame_;
    }
  }
  bring(missing);
  if (seen != taken_ || brought_ > 0) take(std::move(seen));
}

void ParticlePages::bring(const std::vector<std::uint32_t>& missing) {
  if (missing.empty()) return;
  std::vector<std::uint32_t> free;
  for (std::uint32_t place = 0; place < places(); ++place) {
    if (used_[place] != frame_) free.push_back(place);
  }
  std::stable_sort(
      free.begin(), free.end(), [this](std::uint32_t a, std::uint32_t b) { return used_[a] < used_[b]; });
  std::vector<Packed> packed(missing.size());
  const WaitAtLast wait{buffers_.device()};  // the device reads `packed` until then
  for (std::size_t i = 0; i < missing.size(); ++i) {
    queue(missing[i], free[i], packed[i]);
    ++brought_;
  }
}

void ParticlePages::queue(std::uint32_t page, std::uint32_t place, Packed& packed) {
  if (page_at_[place] != kNowhere) place_of_[page_at_[place]] = kNowhere;
  page_at_[place] = kNowhere;
  const GaussianSet& all = source();
  const auto first = static_cast<Eigen::Index>(page) * kPageParticles;
  const auto last = std::min(first + static_cast<Eigen::Index>(kPageParticles), all.size());
  const std::size_t at = std::size_t{place} * kPageParticles, stride = buffers_.stride;
  const std::size_t full = kept_.full_rows() * kPageParticles;

  packed.params = kept_.packed(all, first, last, kPageParticles);
  const std::span<const float> params(packed.params);
  if (levels_) {
    packed.detail.assign(std::size_t{SIM_DETAIL} * kPageParticles, 0.0F);
    const auto put = [&](const std::vector<float>& from, std::size_t row) {
      std::copy(from.begin() + first,
                from.begin() + last,
                packed.detail.begin() + static_cast<std::ptrdiff_t>(row * kPageParticles));
    };
    put(levels_->from_m, SIM_DETAIL_FROM);
    put(levels_->until_m, SIM_DETAIL_UNTIL);
  }
  if (buffers_.precision() == Precision::kDouble) {
    packed.params_double.assign(params.begin(), params.end());
    packed.detail_double.assign(packed.detail.begin(), packed.detail.end());
    buffers_.params.as_double().queue_rows(at, stride, kPageParticles, packed.params_double);
    buffers_.detail.as_double().queue_rows(at, stride, kPageParticles, packed.detail_double);
  } else {
    buffers_.params.as_float().queue_rows(at, stride, kPageParticles, params.first(full));
    buffers_.params.as_float().queue_rows(
        kept_.full_rows() * stride + at / 2, stride / 2, kPageParticles / 2, params.subspan(full));
    buffers_.detail.as_float().queue_rows(at, stride, kPageParticles, packed.detail);
  }
  if (buffers_.actors > 0) {
    packed.actor_of.assign(all.actor.begin() + first, all.actor.begin() + last);
    packed.actor_of.resize(kPageParticles, 0);
    buffers_.actor_of.queue_rows(at, kPageParticles, kPageParticles, packed.actor_of);
  }
  place_of_[page] = place;
  page_at_[place] = page;
  used_[place] = frame_;
}

void ParticlePages::take(std::vector<std::uint32_t> pages) {
  const auto clusters = static_cast<std::uint32_t>((source().size() + SIM_CLUSTER - 1) / SIM_CLUSTER);
  std::vector<std::uint32_t> from, at, actor, list;
  for (const std::uint32_t page : pages) {
    const std::uint32_t first = page * kPageClusters;
    for (std::uint32_t k = 0; k < kPageClusters && first + k < clusters; ++k) {
      from.push_back(first + k);
      at.push_back(place_of_[page] * kPageClusters + k);
    }
  }
  ParticleBuffers& b = buffers_;
  b.taken = static_cast<std::uint32_t>(at.size());
  b.cluster_stride = static_cast<std::uint32_t>(round_up(b.taken, 16));
  std::vector<float> bounds(std::size_t{SIM_CLUSTER_ROWS} * b.cluster_stride, 0.0F);
  actor.assign(b.cluster_stride, 0);
  for (std::size_t i = 0; i < from.size(); ++i) {
    for (std::size_t row = 0; row < SIM_CLUSTER_ROWS; ++row) {
      bounds[row * b.cluster_stride + i] = clusters_.bounds[row * clusters_.stride + from[i]];
    }
    actor[i] = clusters_.actor[from[i]];
  }
  at.resize(b.cluster_stride, 0);
  b.cluster_at.assign(at);
  b.cluster_bounds.assign(bounds);
  b.cluster_actor.assign(actor);
  // Particles that deformations may move.
  const std::vector<std::uint32_t>& of = source().actor;
  for (std::size_t i = 0; b.actors > 0 && i < pages.size(); ++i) {
    const std::uint32_t page = pages[i];
    const std::size_t first = std::size_t{page} * kPageParticles;
    const std::size_t last = std::min(first + kPageParticles, of.size());
    for (std::size_t k = first; k < last; ++k) {
      if (of[k] == 0) continue;
      list.push_back(static_cast<std::uint32_t>(std::size_t{place_of_[page]} * kPageParticles + k - first));
    }
  }
  b.actor_list.assign(list);
  taken_ = std::move(pages);  // after all pages are on the device
}

}  // namespace simuli
