#pragma once
// The library in one header: #include <simuli/simuli.hpp>. All names are in namespace simuli; errors are
// thrown as simuli::Error. Conventions: right-handed frames, metres, radians, seconds; a_from_b maps
// coordinates in b to coordinates in a; quaternions are (w, x, y, z).
//
//   const auto device = simuli::Device::best();
//   simuli::SceneFile file = simuli::read_scene("drive.scene");
//   const simuli::Sensor lidar = simuli::SensorRig(file).find("hesai_pandar128");
//   simuli::SceneOnDevice scene(device, std::move(file.scene));
//   const simuli::Frame frame = scene.render(lidar, simuli::Shot::along(file.world_from_rig, lidar, 1.5));
//   simuli::point_cloud(frame);  // its returns: x y z, intensity, range, drop, ring, time
//
// <simuli/opencl.h>: an own context and queue, and frames as device memory.
