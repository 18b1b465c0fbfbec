#pragma once
// Rendered frames and their labels as other programs' data sets have them. Beside frames.json, in the folder
// that holds all sensors' frames.
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/frames_file.hpp"

namespace simuli {

/// Of one sensor, with labels.
struct LabelledFrames {
  std::string folder = {};  // below the one that holds all; empty: that one
  FramesRecord record;
};

/// Error{kUsage} naming the sensor unless those can be labelled in that format, "json" (frames.json alone),
/// "kitti", "coco" or "nuscenes": COCO and KITTI need a camera,
/// KITTI and nuScenes pinholes.
void need_label_format(const std::string& format, const std::vector<Sensor>& sensors);

/// Of each camera, in its folder's "kitti": image_2/NNNNNN.png (the same files), label_2/NNNNNN.txt and
/// calib/NNNNNN.txt of the object benchmark, label_02.txt of the tracking benchmark. Boxes of actors that show
/// a pixel, as KITTI has them: px from the middle of the first pixel on, m in the camera's frame (x right,
/// y down), upright there, the point under the middle, `truncated` and `occluded` by ActorLabel (1 from a share
/// of 0.1 on, 2 from 0.5 on); 2D boxes are the projected ones. The velodyne of calib is the rig.
void write_kitti_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);

/// coco.json: pictures of all cameras, a category for each kind, and for each actor that shows a pixel its mask
/// (run lengths), bbox [x, y, width, height] and area of it; and, beside what COCO has, "track_id",
/// "bbox_projected", "occlusion" and "truncation".
void write_coco_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);

/// v1.0-simuli/*.json, whose data root is `root`: a sample for each frame of the first LiDAR, else of the first
/// camera, with what the others saw nearest to it; annotations of actors that show a pixel or have a return in
/// any of them, at the time and place that the first that has labels of them saw them at. World coordinates are
/// its global frame; time 0 is kNuscenesStart_us.
void write_nuscenes_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);
inline constexpr double kNuscenesStart_us = 1e12;

}  // namespace simuli
