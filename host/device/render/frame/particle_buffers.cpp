#include "host/device/render/frame/particle_buffers.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <numeric>

#include "cl/shared/layout.h"
#include "host/core/base/error.hpp"
#include "host/device/render/frame/particle_clusters.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {
namespace {

static_assert(static_cast<double>(kDetailFade) == SIM_DETAIL_FADE);
static_assert(kMeanRow == SIM_MEAN && kLogScaleRow == SIM_LOG_SCALE && kRotationRow == SIM_ROTATION &&
              kOpacityRow == SIM_OPACITY && kShRow == SIM_SH);

/// Stores a row of coefficients as halves, two per float of `target`.
void store_halves(const Eigen::Ref<const Eigen::ArrayXf>& row, float* target) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    const Eigen::half value(row[i]);
    std::memcpy(reinterpret_cast<std::byte*>(target) + 2 * i, &value.x, 2);
  }
}

void load_halves(const float* source, Eigen::Ref<Eigen::ArrayXf> row) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    Eigen::half value;
    std::memcpy(&value.x, reinterpret_cast<const std::byte*>(source) + 2 * i, 2);
    row[i] = static_cast<float>(value);
  }
}

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

ParticleSizes ParticleSizes::of(std::uint64_t particles, int sh_degree, std::uint64_t actors) {
  return {static_cast<std::uint64_t>(param_rows(sh_degree)), round_up(particles, 16), actors};
}

KeptParticles KeptParticles::of(const GaussianSet& set, const RenderOptions& options) {
  const KeptParticles kept{std::min(set.sh_degree, options.sh_degree), options.sh_storage};
  if (kept.sh_storage != ShStorage::kHalf) return kept;
  if (options.precision == Precision::kDouble) {
    throw Error(ErrorKind::kUsage, "sh_storage: found half in double precision, allowed full");
  }
  const auto sh = set.params.middleCols(kShRow, static_cast<Eigen::Index>(kept.rows()) - kShRow);
  for (Eigen::Index i = 0; i < sh.size(); ++i) {
    const float value = sh(i % sh.rows(), i / sh.rows());
    if (!Eigen::numext::isinf(Eigen::half(value))) continue;
    throw Error(ErrorKind::kUsage,
                fmt::format("sh_storage: found half and a coefficient of {}, allowed at most 65504", value));
  }
  return kept;
}

std::vector<float> KeptParticles::packed(const GaussianSet& set,
                                         Eigen::Index first,
                                         Eigen::Index last,
                                         std::size_t stride) const {
  const std::size_t full = full_rows();
  // Padding consists of invisible particles with normalisable quaternions.
  std::vector<float> padded(full * stride + (rows() - full) * stride / 2, 0.0F);
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto column = set.params.col(static_cast<Eigen::Index>(row)).segment(first, last - first);
    if (row >= full) {
      store_halves(column, padded.data() + full * stride + (row - full) * stride / 2);
      continue;
    }
    float* target = padded.data() + row * stride;
    float* const end = std::copy(column.data(), column.data() + column.size(), target);
    const float filler = row == kRotationRow ? 1.0F : row == kOpacityRow ? -80.0F : 0.0F;
    std::fill(end, target + stride, filler);
  }
  return padded;
}

ParticleBuffers::ParticleBuffers(const Device& device, const GaussianSet& set, Precision precision)
    : BufferTable(device, precision), kind(set.kind), id_(next_id()) {
  upload(set);
}

ParticleBuffers::ParticleBuffers(const Device& device, const GaussianSet& set, const RenderOptions& options)
    : ParticleBuffers(device, GaussianSet(set.kind, 0, 0), options.precision) {
  stays_ = options;
  if (options.detail > 0.0) {
    const DetailLevels levels = detail_levels(set);
    upload(levels.set, &levels);
  } else {
    upload(set);
  }
}

void ParticleBuffers::upload(const GaussianSet& set) { upload(set, nullptr); }

void ParticleBuffers::upload(const GaussianSet& set, const DetailLevels* levels) {
  if (set.size() > SIM_PARTICLE_MASK) {
    throw Error(ErrorKind::kDevice,
                fmt::format("particles: found {}, allowed {} in one set", set.size(), SIM_PARTICLE_MASK));
  }
  const KeptParticles kept =
      stays_ ? KeptParticles::of(set, *stays_) : KeptParticles{set.sh_degree, ShStorage::kFull};
  kind = set.kind;
  sh_degree = kept.sh_degree;
  sh_storage = kept.sh_storage;
  count = static_cast<std::uint32_t>(set.size());
  stride = static_cast<std::uint32_t>(round_up(count, 16));
  params.assign(kept.packed(set, 0, set.size(), stride));
  upload_actors(set.actor);
  if (!stays_) return;
  if (levels != nullptr) {
    std::vector<float> reported(std::size_t{SIM_DETAIL} * stride, 0.0F);
    std::copy(levels->from_m.begin(), levels->from_m.end(), reported.begin() + SIM_DETAIL_FROM * stride);
    std::copy(levels->until_m.begin(), levels->until_m.end(), reported.begin() + SIM_DETAIL_UNTIL * stride);
    detail.assign(reported);
  }
  const ParticleClusters clusters = clusters_of(set, levels);
  cluster_stride = clusters.stride;
  cluster_bounds.assign(clusters.bounds);
  cluster_actor.assign(clusters.actor);
}

void ParticleBuffers::refresh_actors() {
  std::vector<std::uint32_t> actor = actor_of.download();
  actor.resize(actor.empty() ? 0 : count);
  upload_actors(actor);
}

void ParticleBuffers::upload_actors(const std::vector<std::uint32_t>& actor) {
  actors = actor.empty() ? 0 : *std::max_element(actor.begin(), actor.end());
  if (!actor.empty() && actor.size() != count) {
    throw Error(ErrorKind::kInternal, "particles: one actor per particle is needed, or none at all");
  }
  std::vector<std::uint32_t> of, first, list;
  if (actors > 0) {
    of = actor;
    of.resize(stride, 0);
    first.assign(std::size_t{actors} + 1, 0);
    for (const std::uint32_t a : actor) {
      if (a > 0) ++first[a];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    list.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (actor[i] > 0) list[next[actor[i] - 1]++] = i;
    }
  }
  actor_of.assign(of);
  actor_list.assign(list);
  actor_first.assign(first);
}

GaussianSet ParticleBuffers::download() const {
  GaussianSet set(kind, sh_degree, count);
  const std::vector<float> padded = params.download_float();
  const std::size_t full_rows = KeptParticles{sh_degree, sh_storage}.full_rows();
  for (std::size_t row = 0; row < KeptParticles{sh_degree, sh_storage}.rows(); ++row) {
    auto column = set.params.col(static_cast<Eigen::Index>(row));
    if (row >= full_rows) {
      load_halves(padded.data() + full_rows * stride + (row - full_rows) * stride / 2, column);
      continue;
    }
    const float* source = padded.data() + row * stride;
    std::copy(source, source + count, column.data());
  }
  if (actors > 0) {
    set.actor = actor_of.download();
    set.actor.resize(count);
  }
  return set;
}

}  // namespace simuli
