// The device memory of a frame and what kernels are specialised for.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <numeric>

#include "host/base/error.hpp"
#include "host/render/options/sh_degree.hpp"
#include "host/render/frame/stages.hpp"

namespace simuli {
namespace {

/// A row of coefficients as halves, two in each float of `target`.
void store_halves(const Eigen::Ref<const Eigen::ArrayXf>& row, float* target) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    const Eigen::half value(row[i]);
    if (Eigen::numext::isinf(value)) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("sh_storage: found half and a coefficient of {}, allowed at most 65504", row[i]));
    }
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

}  // namespace

BuildOptions Variant::options() const {
  BuildOptions options;
  // Only where there are any: programs of scenes without actors are the same as ever.
  if (actors) options.define("ACTORS", true).define("ACTOR_MOTION", actor_motion);
  options.real(precision)
      .define("SENSOR", sensor)
      .define("LENS", lens)
      .define("MOVING", moving)
      .define("ORIGINS", origins)
      .define("SH_DEGREE", sh_degree)
      .define("MEDIAN", median)
      .define("PROJECTION", projection)
      .define("V", shape.lanes);
  if (math == Math::kPrecise) options.define("MATH_PRECISE", true);
  if (sh_storage == ShStorage::kHalf) options.define("SH_HALF", true);
  return options;
}

RayBuffers::RayBuffers(const Device& device, const RayGrid& grid, Precision precision)
    : sensor_ray(device, "sensor rays", precision),
      u(device, "ray places", precision),
      row_lut(device, "beam table", grid.row_lut),
      row_elevation(device, "beam elevations", precision),
      tile_rows(device, "first rows of tiles", grid.tile_rows),
      tile_row_of_row(device, "tile rows of rows", grid.tile_row_of_row),
      column_of_bin(device, "tile columns of places", grid.column_of_bin),
      mask_row_of_row(device, "mask rows of rows"),
      areas(device, "ray mask") {
  sensor_ray.assign(grid.sensor_ray);
  u.assign(grid.u);
  row_elevation.assign(grid.row_elevation);
}

ParticleBuffers::ParticleBuffers(const Device& device, const GaussianSet& set, Precision precision)
    : kind(set.kind),
      params(device, "particles", precision),
      actor_of(device, "actors of particles"),
      actor_list(device, "particles of actors"),
      actor_first(device, "actors in the list") {
  upload(set);
}

ParticleBuffers::ParticleBuffers(const Device& device, const GaussianSet& set, const RenderOptions& options)
    : ParticleBuffers(device, GaussianSet(set.kind, 0, 0), options.precision) {
  if (options.sh_storage == ShStorage::kHalf && options.precision == Precision::kDouble) {
    throw Error(ErrorKind::kUsage, "sh_storage: found half in double precision, allowed full");
  }
  sh_storage = options.sh_storage;
  kept_sh_ = options.sh_degree;
  sh_error_ = options.sh_error;
  upload(set);
}

void ParticleBuffers::upload(const GaussianSet& set) {
  if (set.size() > SIM_PARTICLE_MASK) {
    throw Error(ErrorKind::kDevice,
                fmt::format("particles: found {}, allowed {} in one set", set.size(), SIM_PARTICLE_MASK));
  }
  kind = set.kind;
  sh_degree = kept_sh_degree(set, kept_sh_, sh_error_);
  count = static_cast<std::uint32_t>(set.size());
  stride = static_cast<std::uint32_t>(round_up(count, 16));
  const auto rows = static_cast<std::size_t>(param_rows(sh_degree));
  const std::size_t full_rows = sh_storage == ShStorage::kHalf ? SIM_SH : rows;
  // Padding is made of particles that nobody can see, and whose quaternions can be normalised.
  std::vector<float> padded(full_rows * stride + (rows - full_rows) * stride / 2, 0.0F);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto column = set.params.col(static_cast<Eigen::Index>(row));
    if (row >= full_rows) {
      store_halves(column, padded.data() + full_rows * stride + (row - full_rows) * stride / 2);
      continue;
    }
    float* target = padded.data() + row * stride;
    std::copy(column.data(), column.data() + count, target);
    const float filler = row == kRotationRow ? 1.0F : row == kOpacityRow ? -80.0F : 0.0F;
    std::fill(target + count, target + stride, filler);
  }
  params.assign(padded);
  upload_actors(set.actor);
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
  const auto rows = static_cast<std::size_t>(set.params.cols());
  const std::size_t full_rows = sh_storage == ShStorage::kHalf ? SIM_SH : rows;
  for (std::size_t row = 0; row < rows; ++row) {
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

FrameBuffers::FrameBuffers(const Device& device, Precision precision)
    : sensor(device, "sensor constants", precision, SIM_SENSOR_REALS),
      actors(device, "actor poses", precision),
      world_ray(device, "world rays", precision),
      records(device, "records", precision),
      motions(device, "particle motions", precision),
      footprints(device, "footprints"),
      keys(device, "range keys"),
      order(device, "visible particles"),
      order_keys(device, "visible keys"),
      emission(device, "emission"),
      tile(device, "instance tiles"),
      payload(device, "instances"),
      first(device, "tile ranges"),
      out(device, "ray outputs", precision),
      grad_out(device, "ray gradients", precision),
      grads(device, "instance gradients", precision),
      ray_error(device, "ray errors", precision),
      instance_error(device, "instance errors", precision),
      ray_grads(device, "ray gradients", precision),
      pose_grads(device, "pose gradients", precision),
      counts(device, "counts"),
      key_scratch(device, "sort keys"),
      value_scratch(device, "sort values") {}

}  // namespace simuli
