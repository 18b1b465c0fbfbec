#pragma once
// A particle set of which the device stores only the parts that frames may see (METHOD section 4).
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/levels/levels.hpp"
#include "host/device/render/pages/frame_sight.hpp"

namespace simuli {

/// Consecutive clusters that are loaded and evicted together.
inline constexpr std::uint32_t kPageClusters = 8;
inline constexpr std::uint32_t kPageParticles = kPageClusters * SIM_CLUSTER;

/// Returns the number of pages of `set` that fit on the device at once: within options.particle_memory_mb,
/// including frame buffers by particle, and within the device's largest buffer. At most all pages; 0 when none
/// fits.
[[nodiscard]] std::uint32_t pages_that_fit(const Device& device,
                                           const GaussianSet& set,
                                           const RenderOptions& options);
/// Returns the number of pages of all particles.
[[nodiscard]] std::uint32_t page_count(const GaussianSet& set, const RenderOptions& options);

/// Particles that do not change, in as many device pages as fit. Before a frame, bring() loads the missing
/// pages that the frame may see in place of the least recently used pages. A frame uses its particles in the
/// order of the set, wherever they are stored, so that the bits equal those of a full upload.
class ParticlePages {
 public:
  /// Keeps `set` and, with options.detail, its levels. Throws as ParticleBuffers(), and Error{kUsage} when no
  /// page fits.
  ParticlePages(const Device& device,
                std::shared_ptr<const GaussianSet> set,
                const RenderOptions& options,
                std::uint32_t places);

  /// Waits for the device when pages must be loaded. Throws Error{kDevice} with the numbers when the frame may
  /// see more than fits.
  void bring(const FrameSight& sight);
  /// The particles of the frame, as of the last bring().
  [[nodiscard]] const ParticleBuffers& buffers() const { return buffers_; }

  [[nodiscard]] std::uint32_t pages() const { return static_cast<std::uint32_t>(place_of_.size()); }
  [[nodiscard]] std::uint32_t places() const { return static_cast<std::uint32_t>(page_at_.size()); }
  /// Pages that the last bring() found visible, and pages that it loaded.
  [[nodiscard]] std::uint32_t seen() const { return static_cast<std::uint32_t>(taken_.size()); }
  [[nodiscard]] std::uint32_t brought() const { return brought_; }

 private:
  /// A page being uploaded.
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
  std::vector<ParticleBounds> bounds_;  // of pages, or of their clusters where a page has several actors
  std::vector<std::uint32_t> first_bounds_;  // [pages + 1]
  ParticleBuffers buffers_;
  std::vector<std::uint32_t> place_of_;  // [pages] position on the device; kNowhere: not loaded
  std::vector<std::uint32_t> page_at_;  // [positions] page; kNowhere: none
  std::vector<std::uint64_t> used_;  // [positions] last frame that used it
  std::vector<std::uint32_t> taken_;  // pages of the last frame, ascending
  std::uint64_t frame_ = 0;
  std::uint32_t brought_ = 0;
};

}  // namespace simuli
