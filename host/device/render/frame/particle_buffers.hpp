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

/// Sizes of a particle set.
struct ParticleSizes {
  std::uint64_t rows = 0;    // param_rows
  std::uint64_t stride = 0;  // particles, rounded up
  std::uint64_t actors = 0;
  bool levels = false;
  std::uint64_t clusters = 0;  // with bounds, rounded up
  bool paged = false;

  [[nodiscard]] static ParticleSizes of(std::uint64_t particles, int sh_degree, std::uint64_t actors);
};

/// The part of a set that is stored on the device.
struct KeptParticles {
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;

  /// Returns the rows of a set that options.sh_degree keeps, stored as options.sh_storage specifies. Throws
  /// Error{kUsage} when halves are requested in double precision or cannot represent a coefficient (above
  /// 65504).
  [[nodiscard]] static KeptParticles of(const GaussianSet& set, const RenderOptions& options);
  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(param_rows(sh_degree)); }
  /// Number of rows stored as reals; the others are halves.
  [[nodiscard]] std::size_t full_rows() const { return sh_storage == ShStorage::kHalf ? SIM_SH : rows(); }
  /// Returns the rows SIM_MEAN.. of particles [first, last): [full_rows][stride] floats, then the halves, two
  /// per float. Columns beyond `last` are invisible particles.
  [[nodiscard]] std::vector<float> packed(const GaussianSet& set,
                                          Eigen::Index first,
                                          Eigen::Index last,
                                          std::size_t stride) const;
};

/// Particles of one set on the device: each parameter is a row of `stride` reals. Training changes them there.
struct ParticleBuffers : BufferTable<ParticleSizes> {
  ParticleBuffers(const Device& device, const GaussianSet& set, Precision precision);
  /// For particles that do not change: frames leave out clusters that they cannot see, with the same results.
  /// Only the SH bands that options.sh_degree keeps take memory, stored as options.sh_storage specifies. With
  /// options.detail the set's levels of detail are added, which increases the number of particles. Throws
  /// Error{kUsage} when halves are requested in double precision or cannot represent a coefficient (above
  /// 65504).
  ParticleBuffers(const Device& device, const GaussianSet& set, const RenderOptions& options);
  void upload(const GaussianSet& set);
  [[nodiscard]] GaussianSet download() const;
  SetKind kind = SetKind::kCamera;
  int sh_degree = 0;
  ShStorage sh_storage = ShStorage::kFull;
  std::uint32_t count = 0;
  std::uint32_t stride = 0;
  /// A number unique to each object: gradients of a pass are written only for the particles that it rendered.
  [[nodiscard]] std::uint64_t id() const { return id_; }
  /// [param_rows][stride]; with ShStorage::kHalf the rows from SIM_SH on are halves, two per float.
  Reals params{*this, "params", [](const ParticleSizes& s) { return s.rows * s.stride; }};
  /// GaussianSet::actor. Empty without actors.
  std::uint32_t actors = 0;  // the largest number in actor_of
  Words actor_of{
      *this, "actor_of", [](const ParticleSizes& s) { return s.actors > 0 ? s.stride : 0; }};  // [stride]
  /// Particles of actors, consecutive for each actor; and the first of each actor.
  Words actor_list{*this, "actor_list", [](const ParticleSizes& s) { return s.actors > 0 ? s.stride : 0; }};
  Words actor_first{
      *this, "actor_first", [](const ParticleSizes& s) { return s.actors > 0 ? s.actors + 1 : 0; }};
  /// Levels of detail; empty without.
  Reals detail{*this, "detail", [](const ParticleSizes& s) { return s.levels ? SIM_DETAIL * s.stride : 0; }};
  /// Bounds of clusters of particles that do not change (particle_clusters.hpp); empty otherwise, and no
  /// cluster is culled.
  std::uint32_t cluster_stride = 0;  // clusters, rounded up
  Reals cluster_bounds{*this, "cluster_bounds", [](const ParticleSizes& s) {
                         return SIM_CLUSTER_ROWS * s.clusters;
                       }};  // [SIM_CLUSTER_ROWS][cluster_stride]
  Words cluster_actor{
      *this, "cluster_actor", [](const ParticleSizes& s) { return s.clusters; }};  // [cluster_stride]
  /// For a set that is only partly on the device (host/device/render/pages): position, in clusters, of the
  /// clusters of a frame in frame order; bounds are in that order. Empty otherwise: frames use all clusters.
  bool paged = false;
  std::uint32_t taken = 0;  // clusters
  Words cluster_at{
      *this, "cluster_at", [](const ParticleSizes& s) { return s.paged ? s.clusters : 0; }};  // [taken]
  /// Number of particles in a frame.
  [[nodiscard]] std::uint32_t in_frame() const { return paged ? taken * SIM_CLUSTER : count; }
  /// Updates the members derived from actor_of after it changed on the device (relocated or added particles).
  /// Waits.
  void refresh_actors();

 private:
  std::uint64_t id_;
  std::optional<RenderOptions> stays_;  // set for particles that do not change
  void upload(const GaussianSet& set, const DetailLevels* levels);
  void upload_actors(const std::vector<std::uint32_t>& actor);
};

}  // namespace simuli
