#pragma once
// The library in one header: #include <simuli/simuli.hpp>. Everything is in namespace simuli; what goes wrong
// is thrown as simuli::Error. Conventions: right-handed frames, metres, radians, seconds; a_from_b maps
// coordinates in b to coordinates in a; quaternions are (w, x, y, z).
//
//   const auto device = simuli::Device::best();
//   simuli::SceneFile file = simuli::read_scene("drive.scene");
//   simuli::Simulator simulator(device, std::move(file.scene));
//   const auto frame = simulator.render(simuli::builtin_lidar("hesai_pandar128"), shot);   // LidarFrame
//   const auto image = simulator.render(camera, shot);                                     // Image
//
// Devices: Device::adopt() works on a cl_context and queue of the caller's; Simulator::pass()
// holds the cl_mem of the last frame.
#include "host/base/error.hpp"
#include "host/base/image.hpp"
#include "host/render/scene/renderer.hpp"
#include "host/render/scene/simulator.hpp"
#include "host/runtime/device.hpp"
#include "host/scene/edit.hpp"
#include "host/scene/pose.hpp"
#include "host/scene/scene.hpp"
#include "host/sensors/camera.hpp"
#include "host/sensors/lidar_library.hpp"
#include "host/sensors/lidar_model.hpp"
#include "host/sensors/trajectory.hpp"
#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/ply.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"
