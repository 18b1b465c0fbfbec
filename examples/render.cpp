// render SCENE SENSOR: what another LiDAR would see where the recorded one was, for instance hesai_pandar128.
#include <cstdio>
#include <exception>
#include <simuli/simuli.hpp>
#include <utility>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: render SCENE LIDAR\n"), 2;
  try {
    simuli::SceneFile file = simuli::read_scene(argv[1]);
    const simuli::SensorRig rig(file);
    const simuli::Trajectory& path = file.world_from_rig;
    simuli::SceneOnDevice scene(simuli::Device::best(), std::move(file.scene));

    const simuli::Sensor lidar = rig.find(argv[2]);
    const simuli::LidarFrame sweep =
        scene.render(lidar, simuli::Shot::along(path, lidar, path.start_s())).lidar();
    std::printf("%td of %zu rays returned\n", sweep.returns(), sweep.range.size());

    const simuli::Sensor camera = rig.sensors().at(0);
    simuli::write_image("picture.png",
                        scene.render(camera, simuli::Shot::along(path, camera, path.start_s())).image());
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "render: %s\n", error.what()), 1;
  }
  return 0;
}
