#pragma once
// What a rendered frame becomes on disk: pictures of cameras, clouds and range pictures of LiDARs.
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/apps/cli/draw/unseen.hpp"
#include "host/apps/cli/render/plan.hpp"
#include "host/device/render/outputs/camera_output.hpp"
#include "host/device/render/outputs/cloud.hpp"
#include "host/device/render/outputs/labels.hpp"
#include "host/device/support/support.hpp"
#include "io/scene/frames_file.hpp"

namespace simuli::cli {

/// As asked for on the command line.
struct FileOptions {
  std::string images = "png";
  std::string clouds = "ply";
  std::string cloud_frame;      // empty: world; of recordings sensor
  std::string outputs = "rgb";  // camera_output_names(), parted by commas
  std::string values = "exr";   // of all outputs but pictures
  bool mark_unseen = false;     // in pictures, what no recorded camera faced
  std::string labels;           // json, kitti, coco or nuscenes; empty: none
};

void add_file_options(Command sub, FileOptions& options);

/// What tells of the frames of a scene what they don't: all of them outlive who uses it.
struct FrameSources {
  const Scene& scene;
  const ActorCopies& copies;
  SupportOnDevice* support = nullptr;  // where needs_support()
  LabelsOnDevice* labels = nullptr;    // with labels
};

/// Writes the files of one sensor's frames.
class FrameFiles {
 public:
  /// `recorded` marks what these did not face and must outlive this; null: nothing is marked. Error{kUsage}
  /// for outputs that there are not, or not of this sensor, or not as these values.
  FrameFiles(const FileOptions& options,
             const Sensor& sensor,
             const Plan& plan,
             const RecordedViews* recorded);

  /// What frames are to be rendered with.
  [[nodiscard]] FrameRequest request() const {
    return request_for(outputs_, {.camera_median = recorded_ != nullptr, .actors = !options_.labels.empty()});
  }
  [[nodiscard]] bool needs_support() const;
  /// Files "STEM..." into the folder; returns the frame with their names and its labels. `next`: the shot
  /// that flow leads to; null: there is none.
  [[nodiscard]] FrameRecord write(const Frame& frame,
                                  const std::filesystem::path& folder,
                                  const std::string& stem,
                                  const FrameSources& sources,
                                  const Shot* next) const;
  /// Says in the record what the files hold.
  void describe(FramesRecord& record, const Scene& scene) const;

 private:
  void write_outputs(const Frame& frame,
                     const std::filesystem::path& folder,
                     const std::string& stem,
                     const FrameSources& sources,
                     const Shot* next,
                     FrameRecord& record) const;
  void write_cloud(const Frame& frame,
                   const std::filesystem::path& folder,
                   const std::string& stem,
                   const FrameSources& sources,
                   FrameRecord& record) const;

  FileOptions options_;
  bool is_camera_;
  std::vector<CameraOutput> outputs_;
  CloudOptions cloud_;
  const RecordedViews* recorded_;
};

/// As a picture: what a camera saw, with what `recorded` did not face marked, unless it is null; or a LiDAR's
/// ranges as colours.
[[nodiscard]] Image shown(const Frame& frame, const RecordedViews* recorded);

}  // namespace simuli::cli
