#pragma once
// Cutting a drive along its path into chunks.
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/train/chunk/chunk_options.hpp"

namespace simuli {

/// An interval [from_m, to_m) along the path. The first and the last chunk extend to the ends of the drive.
struct DriveChunk {
  double from_m = 0.0, to_m = 0.0;
};

/// The path of the rig from a log's first frame to its last, parametrised by arc length in m.
class DrivenPath {
 public:
  /// Throws Error{kInput} for a log without frames or path.
  explicit DrivenPath(const Log& log);
  ~DrivenPath();
  DrivenPath(const DrivenPath&) = delete;
  DrivenPath& operator=(const DrivenPath&) = delete;

  [[nodiscard]] double length_m() const { return length_m_; }
  /// Returns the arc length at a time, clamped to the path's ends.
  [[nodiscard]] double place_at(double time_s) const;
  /// Returns the arc length of the path position nearest to a point of the scene, accurate to 0.25 m.
  [[nodiscard]] double place_nearest(const Eigen::Vector3f& p_scene) const;
  /// Returns path positions (scene, m) within the chunk, in order and about `step_m` apart; at least one.
  [[nodiscard]] std::vector<Eigen::Vector3d> places_of(const DriveChunk& chunk, double step_m) const;
  /// Largest distance in m of the path from the scene's origin.
  [[nodiscard]] double farthest_m() const { return farthest_m_; }

 private:
  struct Search;
  std::vector<double> time_s_, position_m_;  // of the path's poses
  double length_m_ = 0.0, farthest_m_ = 0.0;
  std::unique_ptr<Search> search_;
};

/// Cuts the path into chunks of equal length near options.length_m; one chunk when that is 0.
[[nodiscard]] std::vector<DriveChunk> cut(const DrivenPath& path, const ChunkOptions& options);

/// Returns the index of the chunk that contains the arc length.
[[nodiscard]] std::size_t chunk_at(const std::vector<DriveChunk>& chunks, double position_m);

/// Returns the iteration at which each chunk ends: iterations are divided in proportion to the chunks' training
/// pictures.
[[nodiscard]] std::vector<int> ends_of(int iterations, const std::vector<std::size_t>& pictures);

/// Returns the log restricted to the training frames (of `frames`) of a chunk, plus some frames up to overlap_m
/// before and after it. For each sensor these are added until their shares that show the chunk sum to
/// `overlap_share` times its own frames, because they see parts of the chunk from a distance. The log keeps the
/// actors present at those times, and none of its frames is held out.
[[nodiscard]] Log log_of(const Log& log,
                         const FrameSelection& frames,
                         const DrivenPath& path,
                         const DriveChunk& chunk,
                         const ChunkOptions& options);

}  // namespace simuli
