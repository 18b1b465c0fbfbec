#pragma once
// A particle set of which the device holds what frames may see (METHOD section 4).
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/levels/levels.hpp"
#include "host/device/render/pages/frame_sight.hpp"

namespace simuli {

/// Consecutive clusters of particles that come to the device and go together.
inline constexpr std::uint32_t kPageClusters = 8;
inline constexpr std::uint32_t kPageParticles = kPageClusters * SIM_CLUSTER;

/// How many pages of `set` fit on the device at once: into options.particle_memory_mb, with all that a frame
/// keeps of a particle, and into the device's largest buffer. Never more than there are; 0 when not one does.
[[nodiscard]] std::uint32_t pages_that_fit(const Device& device,
                                           const GaussianSet& set,
                                           const RenderOptions& options);
/// Pages of all particles.
[[nodiscard]] std::uint32_t page_count(const GaussianSet& set, const RenderOptions& options);

/// Particles that stay as they are, in as many places on the device as there is room for. Before a frame
/// bring() puts there what it may see and was not there, where what was least recently seen is. A frame takes
/// its particles in the order of the set, wherever they lie: the same bits as with all of them there.
class ParticlePages {
 public:
  /// `set` is kept; with options.detail its levels, too. Errors of ParticleBuffers(); Error{kUsage} for no
  /// place at all.
  ParticlePages(const Device& device,
                std::shared_ptr<const GaussianSet> set,
                const RenderOptions& options,
                std::uint32_t places);

  /// Waits for the device where something has to be brought. Error{kDevice} with numbers when the frame may
  /// see more than fits.
  void bring(const FrameSight& sight);
  /// What a frame takes: as the last bring() left it.
  [[nodiscard]] const ParticleBuffers& buffers() const { return buffers_; }

  [[nodiscard]] std::uint32_t pages() const { return static_cast<std::uint32_t>(place_of_.size()); }
  [[nodiscard]] std::uint32_t places() const { return static_cast<std::uint32_t>(page_at_.size()); }
  /// Pages that the last bring() found in sight, and that it brought.
  [[nodiscard]] std::uint32_t seen() const { return static_cast<std::uint32_t>(taken_.size()); }
  [[nodiscard]] std::uint32_t brought() const { return brought_; }

 private:
  /// A page on its way.
  struct Packed {
    std::vector<float> params, detail;
    std::vector<double> params_double, detail_double;
    std::vector<std::uint32_t> actor_of;
  };
  [[nodiscard]] const GaussianSet& source() const { return levels_ ? levels_->set : *set_; }
  [[nodiscard]] bool in_sight(const FrameSight& sight, std::uint32_t page) const;
  void bring(const std::vector<std::uint32_t>& missing);
  void queue(std::uint32_t page, std::uint32_t place, Packed& packed);
  void take(std::vector<std::uint32_t> pages);

  std::shared_ptr<const GaussianSet> set_;
  std::optional<DetailLevels> levels_;
  KeptParticles kept_;
  ParticleClusters clusters_;           // of all particles
  std::vector<ParticleBounds> bounds_;  // of pages, or where these are not of one actor of their clusters
  std::vector<std::uint32_t> first_bounds_;  // [pages + 1]
  ParticleBuffers buffers_;
  std::vector<std::uint32_t> place_of_;  // [pages], kNowhere: not on the device
  std::vector<std::uint32_t> page_at_;   // [places], kNowhere: none
  std::vector<std::uint64_t> used_;      // [places] the last frame that took it
  std::vector<std::uint32_t> taken_;     // pages of the last frame, rising
  std::uint64_t frame_ = 0;
  std::uint32_t brought_ = 0;
};

}  // namespace simuli
