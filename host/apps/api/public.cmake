# What libsimuli shows: each installed header, and the headers of the tree that it is made of, in order.
# Nothing else becomes public, whatever includes what: headers.cmake refuses a header that needs one which is in
# no line above it. A header of calibration is there when the library has it (SIMULI_CALIBRATION).
set(SIMULI_PUBLIC base sensors scene device options render log files export import training evaluation)
if(SIMULI_CALIBRATION)
  list(APPEND SIMULI_PUBLIC calibration)
endif()

set(SIMULI_PUBLIC_base
  "Errors, version, pictures, clouds, poses, and the keys of options."
  host/core/base/version.hpp host/core/base/one_line.hpp host/core/base/error.hpp host/core/base/image.hpp host/core/base/point_cloud.hpp
  host/core/base/pose.hpp host/core/base/allowed.hpp
  host/core/base/fields.hpp host/core/base/interruption.hpp host/core/base/precision.hpp)
set(SIMULI_PUBLIC_sensors
  "Cameras, LiDARs and the paths that carry them."
  host/core/sensors/lens.hpp host/core/sensors/camera.hpp host/core/sensors/lidar.hpp host/core/sensors/ray_list.hpp
  host/core/sensors/lidar_model.hpp host/core/sensors/lidar_library.hpp host/core/sensors/trajectory.hpp
  host/core/sensors/sensor.hpp)
set(SIMULI_PUBLIC_scene
  "Scenes: particles, actors, appearance, and edits of them."
  host/core/scene/mounting.hpp host/core/scene/gaussians.hpp host/core/scene/appearance.hpp host/core/scene/actor.hpp
  host/core/scene/ray_drop.hpp host/core/scene/pixel_footprint.hpp host/core/scene/visibility_sets.hpp host/core/scene/scene.hpp host/core/scene/occluders.hpp
  host/core/scene/edit.hpp)
set(SIMULI_PUBLIC_device
  "OpenCL devices. Their own handles: <simuli/opencl.h>."
  host/device/runtime/profile.hpp host/device/runtime/device.hpp)
set(SIMULI_PUBLIC_options
  "How frames are rendered: speed against accuracy."
  host/device/render/options/options.hpp host/device/render/options/quality.hpp)
set(SIMULI_PUBLIC_render
  "A scene on a device, a sensor and a shot make a frame."
  host/device/render/scene/shot.hpp host/device/render/scene/ray_results.hpp host/device/render/scene/readings.hpp
  host/device/render/scene/frame.hpp host/device/render/scene/scene_on_device.hpp host/device/render/outputs/cloud.hpp
  host/device/render/outputs/camera_output.hpp host/core/scene/actor_label.hpp
  host/device/render/outputs/labels.hpp host/device/render/outputs/flow.hpp
  host/core/record/support_record.hpp host/core/record/mirror.hpp host/device/support/support.hpp)
set(SIMULI_PUBLIC_log
  "Recorded drives."
  io/log/log.hpp io/log/label_tracks.hpp io/log/frame_spans.hpp io/log/frame_selection.hpp)
set(SIMULI_PUBLIC_files
  "Pictures, splats, clouds, sensor files, scene folders."
  io/picture/image.hpp io/picture/sized_image.hpp io/splat/ply.hpp io/splat/splat_file.hpp
  io/splat/cloud_file.hpp
  io/log/sensor_file.hpp io/scene/training_record.hpp io/scene/scene_folder.hpp
  io/scene/sensor_rig.hpp
  io/scene/rig_file.hpp)
set(SIMULI_PUBLIC_export
  "Drives for other simulators."
  io/export/drive_archive.hpp io/ncore/ncore_export.hpp)
set(SIMULI_PUBLIC_import
  "Logs from the files of others."
  io/import/kitti/kitti.hpp io/import/kitti360/kitti360.hpp io/import/nuscenes/nuscenes.hpp
  io/import/photos/photo_log.hpp
  io/import/points/point_grid.hpp io/import/points/points_log.hpp io/import/ncore/ncore_log.hpp
  io/import/ros2/ros2_log.hpp
  io/import/waymo/waymo.hpp)
set(SIMULI_PUBLIC_training
  "A scene from a log: what `simuli train` does."
  optim/data/path_report.hpp optim/actors/finding_options.hpp
  optim/init/init_options.hpp optim/data/sensor_learning.hpp
 optim/actors/pose_rates.hpp optim/train/schedule.hpp
  optim/train/paper/anchor_options.hpp optim/train/structure_options.hpp optim/train/length_options.hpp
  optim/train/train_options.hpp
  optim/complete/fixer_options.hpp optim/train/chunk/chunk_options.hpp optim/train/train_report.hpp optim/train/training_options.hpp optim/train/ranks/ranks.hpp
 optim/train/training.hpp)
set(SIMULI_PUBLIC_evaluation
  "A scene beside a log: what `simuli eval` does."
  optim/base/metrics.hpp optim/eval/eval_options.hpp
  optim/eval/eval_frames.hpp optim/eval/eval_scores.hpp optim/eval/evaluation.hpp
  optim/eval/held_out_scores.hpp)
set(SIMULI_PUBLIC_calibration
  "Paths, mountings, beams and lenses found from recorded data."
  optim/calibration/path/returns.hpp optim/calibration/path/plane_map.hpp
  optim/calibration/path/odometry.hpp optim/calibration/path/refine.hpp optim/calibration/path/spin.hpp
  optim/calibration/path/align.hpp optim/calibration/beams/beams.hpp optim/calibration/lens/lens_fit.hpp
  optim/calibration/camera/luminance.hpp optim/calibration/camera/camera_edges.hpp
  optim/calibration/camera/camera_texture.hpp optim/calibration/camera/camera_pose.hpp)

# The headers of the tree that this build shows.
set(SIMULI_PUBLIC_PARTS "")
foreach(header IN LISTS SIMULI_PUBLIC)
  list(APPEND SIMULI_PUBLIC_PARTS ${SIMULI_PUBLIC_${header}})
endforeach()
list(FILTER SIMULI_PUBLIC_PARTS INCLUDE REGEX "\\.hpp$")
