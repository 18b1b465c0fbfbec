#pragma once
// A drive cut along its path.
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/train/chunk/chunk_options.hpp"

namespace simuli {

/// A part of the path, [from_m, to_m) along it. The first begins, and the last ends, where the drive does.
struct DriveChunk {
  double from_m = 0.0, to_m = 0.0;
};

/// The way that the rig takes from a log's first frame to its last, by its length.
class DrivenPath {
 public:
  /// Error{kInput} for a log without frames or path.
  explicit DrivenPath(const Log& log);
  ~DrivenPath();
  DrivenPath(const DrivenPath&) = delete;
  DrivenPath& operator=(const DrivenPath&) = delete;

  [[nodiscard]] double length_m() const { return length_m_; }
  /// Along the path, where the rig is then; its ends before and behind.
  [[nodiscard]] double place_at(double time_s) const;
  /// Along the path, at its place nearest to a point of the scene, to 0.25 m.
  [[nodiscard]] double place_nearest(const Eigen::Vector3f& p_scene) const;
  /// Places of the path in that chunk of it (scene, m), in its order, about `step_m` apart; one at least.
  [[nodiscard]] std::vector<Eigen::Vector3d> places_of(const DriveChunk& chunk, double step_m) const;
  /// m, of the path's farthest place from the scene's origin.
  [[nodiscard]] double farthest_m() const { return farthest_m_; }

 private:
  struct Search;
  std::vector<double> time_s_, position_m_;  // of the path's poses
  double length_m_ = 0.0, farthest_m_ = 0.0;
  std::unique_ptr<Search> search_;
};

/// Stretches of equal length, as near to options.length_m as that goes; one when that is 0.
[[nodiscard]] std::vector<DriveChunk> cut(const DrivenPath& path, const ChunkOptions& options);

/// Of which of them a place is.
[[nodiscard]] std::size_t chunk_at(const std::vector<DriveChunk>& chunks, double position_m);

/// Behind which of a drive's iterations each chunk ends that has so many training pictures: in proportion.
[[nodiscard]] std::vector<int> ends_of(int iterations, const std::vector<std::size_t>& pictures);

/// The log with the training frames (of `frames`) of a chunk alone, and with some of those up to overlap_m
/// before and behind it: of each sensor as many as show it, added up by the share of what they show that is
/// of it, times `beside`; what a chunk shows from afar is theirs to say. Of the actors it has those that
/// are there meanwhile. None of its frames is to be held out any more.
[[nodiscard]] Log log_of(const Log& log,
                         const FrameSelection& frames,
                         const DrivenPath& path,
                         const DriveChunk& chunk,
                         const ChunkOptions& options);

}  // namespace simuli
