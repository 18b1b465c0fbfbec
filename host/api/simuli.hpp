#pragma once
// The library in one header: #include <simuli/simuli.hpp>. Everything is in namespace simuli; what goes wrong
// is thrown as simuli::Error. Conventions: right-handed frames, metres, radians, seconds; a_from_b maps
// coordinates in b to coordinates in a; quaternions are (w, x, y, z).
//
//   const auto device = simuli::Device::best();
//   simuli::SceneFile file = simuli::read_scene("drive.scene");
//   const simuli::Sensor lidar = simuli::SensorRig(file).find("hesai_pandar128");
//   simuli::SceneOnDevice scene(device, std::move(file.scene));
//   const simuli::Frame frame = scene.render(lidar, simuli::Shot::along(file.world_from_rig, lidar, 1.5));
//   frame.points();
//
// Devices: Device::adopt() works on a cl_context and queue of the caller's.
#include "host/base/error.hpp"
#include "host/base/image.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "host/runtime/device.hpp"
#include "host/scene/edit.hpp"
#include "host/scene/pose.hpp"
#include "host/scene/scene.hpp"
#include "host/sensors/camera.hpp"
#include "host/sensors/lidar_library.hpp"
#include "host/sensors/lidar_model.hpp"
#include "host/sensors/trajectory.hpp"
#include "io/picture/image.hpp"
#include "io/log/log.hpp"
#include "io/splat/ply.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"
