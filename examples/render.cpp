// render SCENE LIDAR: what another LiDAR would see where the recorded one was, for instance hesai_pandar128.
#include <cstdio>
#include <exception>
#include <simuli/simuli.hpp>
#include <utility>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: render SCENE LIDAR\n"), 2;
  try {
    simuli::SceneFile file = simuli::read_scene(argv[1]);
    const simuli::LidarModel lidar = simuli::builtin_lidar(argv[2]);
    const double start_s = file.world_from_rig.start_s();
    const auto turn =
        simuli::Shot::along(file.world_from_rig, file.lidars.at(0).rig_from_lidar, start_s, start_s + 0.1);

    simuli::Simulator simulator(simuli::Device::best(), std::move(file.scene));
    const simuli::LidarFrame frame = simulator.render(lidar, turn);
    std::printf("%td of %zu rays returned\n", frame.returns(), frame.range.size());

    const simuli::LogCamera& camera = file.cameras.at(0);
    const auto shot = simuli::Shot::along(file.world_from_rig, camera.rig_from_camera, start_s, start_s);
    simuli::write_image("picture.png", simulator.render(camera.model, shot));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "render: %s\n", error.what()), 1;
  }
  return 0;
}
