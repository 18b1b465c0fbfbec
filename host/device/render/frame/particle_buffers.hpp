#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "cl/shared/cluster.h"
#include "cl/shared/layout.h"
#include "host/core/scene/gaussians.hpp"
#include "host/device/render/device/buffer_table.hpp"
#include "host/device/render/levels/levels.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli {

/// What a particle set is sized by.
struct ParticleSizes {
  std::uint64_t rows = 0;    // param_rows
  std::uint64_t stride = 0;  // particles, rounded up
  std::uint64_t actors = 0;
  bool levels = false;
  std::uint64_t clusters = 0;  // with bounds, rounded up
  bool paged = false;

  [[nodiscard]] static ParticleSizes of(std::uint64_t particles, int sh_degree, std::uint64_t actors);
};

/// What is kept of a set on the device.
struct KeptParticles {
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;

  /// What options.sh_degree keeps of a set, stored as options.sh_storage says. Error{kUsage} when halves are
  /// asked for in double, or cannot hold a coefficient (beyond 65504).
  [[nodiscard]] static KeptParticles of(const GaussianSet& set, const RenderOptions& options);
  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(param_rows(sh_degree)); }
  /// Those that are reals; the rest are halves.
  [[nodiscard]] std::size_t full_rows() const { return sh_storage == ShStorage::kHalf ? SIM_SH : rows(); }
  /// Of SIM_MEAN.. of particles [first, last) of a set: [full_rows][stride] floats, then the halves, two in
  /// a float. What is behind `last` nobody can see.
  [[nodiscard]] std::vector<float> packed(const GaussianSet& set,
                                          Eigen::Index first,
                                          Eigen::Index last,
                                          std::size_t stride) const;
};

/// Particles of one set on the device, each parameter a row of `stride` reals. Training changes them there.
struct ParticleBuffers : BufferTable<ParticleSizes> {
  ParticleBuffers(const Device& device, const GaussianSet& set, Precision precision);
  /// Particles that stay as they are: clusters of them that a frame cannot see are left out of it, with the
  /// same results. Only the bands of spherical harmonics that options.sh_degree keeps take memory, as
  /// options.sh_storage says. With options.detail its levels are with the set: more particles than it has.
  /// Error{kUsage} when halves are asked for in double, or cannot hold a coefficient (beyond 65504).
  ParticleBuffers(const Device& device, const GaussianSet& set, const RenderOptions& options);
  void upload(const GaussianSet& set);
  [[nodiscard]] GaussianSet download() const;
  SetKind kind = SetKind::kCamera;
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  std::uint32_t count = 0;
  std::uint32_t stride = 0;
  /// Another number for each: a pass takes gradients to the particles that it rendered alone.
  [[nodiscard]] std::uint64_t id() const { return id_; }
  /// [param_rows][stride]; of ShStorage::kHalf the rows from SIM_SH on are halves, two in a float.
  Reals params{*this, "params", [](const ParticleSizes& s) { return s.rows * s.stride; }};
  /// GaussianSet::actor. All empty without actors.
  std::uint32_t actors = 0;  // the largest number in actor_of
  Words actor_of{
      *this, "actor_of", [](const ParticleSizes& s) { return s.actors > 0 ? s.stride : 0; }};  // [stride]
  /// Particles of actors, those of an actor consecutive; and where each actor's begin.
  Words actor_list{*this, "actor_list", [](const ParticleSizes& s) { return s.actors > 0 ? s.stride : 0; }};
  Words actor_first{
      *this, "actor_first", [](const ParticleSizes& s) { return s.actors > 0 ? s.actors + 1 : 0; }};
  /// Of levels of detail, where there are any; else empty.
  Reals detail{*this, "detail", [](const ParticleSizes& s) { return s.levels ? SIM_DETAIL * s.stride : 0; }};
  /// Of particles that stay as they are (particle_clusters.hpp); else empty, and every cluster is looked at.
  std::uint32_t cluster_stride = 0;  // clusters, rounded up
  Reals cluster_bounds{*this, "cluster_bounds", [](const ParticleSizes& s) {
                         return SIM_CLUSTER_ROWS * s.clusters;
                       }};  // [SIM_CLUSTER_ROWS][cluster_stride]
  Words cluster_actor{
      *this, "cluster_actor", [](const ParticleSizes& s) { return s.clusters; }};  // [cluster_stride]
  /// Of a set of which a part is here (host/device/render/pages): where, in clusters, that one is which a frame
  /// takes as the first, the second, ...; bounds are in that order. Else empty, and frames take all.
  bool paged = false;
  std::uint32_t taken = 0;  // clusters
  Words cluster_at{
      *this, "cluster_at", [](const ParticleSizes& s) { return s.paged ? s.clusters : 0; }};  // [taken]
  /// Particles that a frame takes.
  [[nodiscard]] std::uint32_t in_frame() const { return paged ? taken * SIM_CLUSTER : count; }
  /// After actor_of changed on the device (particles relocated or added): the other members again. Waits.
  void refresh_actors();

 private:
  std::uint64_t id_;
  std::optional<RenderOptions> stays_;  // so they stay as they are
  void upload(const GaussianSet& set, const DetailLevels* levels);
  void upload_actors(const std::vector<std::uint32_t>& actor);
};

}  // namespace simuli
