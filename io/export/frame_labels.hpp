#pragma once
// Labels of rendered frames in the formats of other data sets, written beside frames.json in the folder of all
// sensors' frames.
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/frames_file.hpp"

namespace simuli {

/// Frames of one sensor with labels.
struct LabelledFrames {
  std::string folder = {};  // relative to the folder of all sensors; empty: that folder
  FramesRecord record;
};

/// Throws Error{kUsage} naming the sensor unless its frames can be labelled in the format "json" (frames.json
/// only), "kitti", "coco" or "nuscenes": COCO and KITTI need a camera, KITTI and nuScenes pinhole cameras.
void need_label_format(const std::string& format, const std::vector<Sensor>& sensors);

/// Writes each camera's files in its folder's "kitti": image_2/NNNNNN.png (links), label_2/NNNNNN.txt and
/// calib/NNNNNN.txt of the object benchmark, label_02.txt of the tracking benchmark. Labels are the boxes of
/// actors with at least one pixel in KITTI's conventions: px from the centre of the first pixel, m in the
/// camera's frame (x right, y down), upright boxes, position of the bottom centre, `truncated` and `occluded`
/// from ActorLabel (1 from a share of 0.1, 2 from 0.5), projected 2D boxes. The velodyne of calib is the rig.
void write_kitti_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);

/// Writes coco.json: pictures of all cameras, a category per kind, and per visible actor its mask (run
/// lengths), bbox [x, y, width, height] and area; in addition to COCO's keys "track_id", "bbox_projected",
/// "occlusion" and "truncation".
void write_coco_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);

/// Writes v1.0-simuli/*.json with the data root `root`: a sample per frame of the first LiDAR, else of the
/// first camera, with the frames of the other sensors nearest in time; annotations of actors with a pixel or a
/// return in any of them, with the time and pose of the first frame that has labels of them. The global frame
/// is the world frame; time 0 is kNuscenesStart_us.
void write_nuscenes_labels(const std::filesystem::path& root, const std::vector<LabelledFrames>& all);
inline constexpr double kNuscenesStart_us = 1e12;

}  // namespace simuli
