#pragma once
// Files of rendered frames: pictures of cameras, clouds and range pictures of LiDARs.
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

/// Options as given on the command line.
struct FileOptions {
  std::string images = "png";
  std::string clouds = "ply";
  std::string cloud_frame;      // empty: world; in recordings: sensor
  std::string outputs = "rgb";  // camera_output_names(), comma-separated
  std::string values = "exr";   // format of all outputs except pictures
  bool mark_unseen = false;     // mark pixels of pictures that no recorded camera faced
  std::string labels;           // json, kitti, coco or nuscenes; empty: none
};

void add_file_options(Command sub, FileOptions& options);

/// Sources of additional outputs of a scene's frames. They must outlive FrameFiles.
struct FrameSources {
  const Scene& scene;
  const ActorCopies& copies;
  SupportOnDevice* support = nullptr;  // only if needs_support()
  LabelsOnDevice* labels = nullptr;    // only with labels
};

/// Writes the files of one sensor's frames.
class FrameFiles {
 public:
  /// `recorded`: pixels outside these views are marked; null: no marks. Must outlive this object. Throws
  /// Error{kUsage} for outputs that are unknown, not of this sensor, or not available in this format.
  FrameFiles(const FileOptions& options,
             const Sensor& sensor,
             const Plan& plan,
             const RecordedViews* recorded);

  /// Returns the request with which frames must be rendered.
  [[nodiscard]] FrameRequest request() const {
    return request_for(outputs_, {.camera_median = recorded_ != nullptr, .actors = !options_.labels.empty()});
  }
  [[nodiscard]] bool needs_support() const;
  /// Writes the files "STEM..." of a frame into the folder. Returns the frame's record with file names and
  /// labels. `next`: the shot that flow refers to; null: no flow.
  [[nodiscard]] FrameRecord write(const Frame& frame,
                                  const std::filesystem::path& folder,
                                  const std::string& stem,
                                  const FrameSources& sources,
                                  const Shot* next) const;
  /// Adds a description of the files to the record.
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

/// Returns a frame as a picture: a camera's colours, with pixels outside the views of `recorded` marked unless
/// it is null, or a LiDAR's ranges as colours.
[[nodiscard]] Image shown(const Frame& frame, const RecordedViews* recorded);

}  // namespace simuli::cli
