#include "optim/init/initialize_depth.hpp"

#include <algorithm>
#include <deque>
#include <utility>

#include "optim/base/frames.hpp"
#include "optim/init/plane_sweep.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

constexpr std::size_t kReach = 8;  // pictures before and after
constexpr double kApart_m = 0.5;  // smallest distance between two of them, or
constexpr double kApart_rad = 0.1;  // smallest rotation; closer pictures add little information

/// Selects frames that are apart from their predecessor.
std::vector<const ImageFrame*> apart(const Log& log,
                                     const LogCamera& camera,
                                     const std::vector<const ImageFrame*>& images) {
  std::vector<const ImageFrame*> out;
  Pose last;
  for (const ImageFrame* frame : images) {
    if (frame->camera != camera.model.name) continue;
    const Pose pose = log.world_from_rig.at(middle_s(*frame)) * camera.rig_from_camera;
    const bool is_apart = out.empty() || (pose.translation - last.translation).norm() >= kApart_m ||
                          pose.rotation.angularDistance(last.rotation) >= kApart_rad;
    if (!is_apart) continue;
    out.push_back(frame);
    last = pose;
  }
  return out;
}

}  // namespace

std::size_t PictureDepths::add_to(PointSet& points, const std::function<void()>& step) const {
  struct Loaded {
    SweepPicture picture;
    Coverage coverage;
  };
  VoxelGrid grid(2.0 * voxel_m);
  const PointBlocks blocks(points);
  for (const LogCamera& camera : log.cameras) {
    const std::vector<const ImageFrame*> frames = apart(log, camera, images);
    expect(log, frames, image_scale);
    std::deque<Loaded> window;  // frames [first, next)
    std::size_t first = 0, next = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      for (; next < frames.size() && next <= k + kReach; ++next) {
        const auto [image, view] = load_view(log, *frames[next], origin, image_scale);
        const PointSet placed =
            actors.placed(points.subset(blocks.seen_from(view)), middle_s(*frames[next]), view);
        std::vector<PointObservation> unused(placed.size());
        Coverage coverage = look_at_points(view, image, placed, voxel_m, SweepPicture::kPixel_px, unused);
        actors.cover(view, middle_s(*frames[next]), coverage);
        window.push_back({sweep_picture(view, image, sky.at(frames[next])), std::move(coverage)});
      }
      for (; first + kReach < k; ++first) window.pop_front();
      std::vector<const SweepPicture*> others;
      for (std::size_t i = 0; i < window.size(); ++i) {
        if (first + i != k) others.push_back(&window[i].picture);
      }
      const Loaded& here = window[k - first];
      for (const Eigen::Vector3d& p : sweep_depths(here.picture, others, here.coverage)) grid.add(p, 0.0);
      step();
    }
    const auto all = std::count_if(images.begin(), images.end(), [&camera](const ImageFrame* frame) {
      return frame->camera == camera.model.name;
    });
    for (std::size_t k = frames.size(); k < static_cast<std::size_t>(all); ++k) step();
  }
  const PointSet found = grid.averages();
  points.append(found);
  return found.size();
}

}  // namespace simuli
