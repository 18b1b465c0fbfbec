#include "host/apps/cli/render/rendered_log.hpp"

#include <fmt/format.h>

#include "io/picture/image.hpp"

namespace simuli::cli {
namespace {

/// Returns the actor with learned corrections included in its track.
Actor as_seen(Actor actor) {
  for (KeyPose& key : actor.track) key = {key.time_s, key.corrected()};
  return actor;
}

}  // namespace

RenderedLog::RenderedLog(const std::filesystem::path& folder,
                         const Scene& scene,
                         const Trajectory& world_from_rig,
                         const std::vector<Sensor>& sensors) {
  log_.folder = folder;
  log_.name = scene.name;
  log_.world_from_rig = world_from_rig;
  for (const Actor& actor : scene.actors) log_.actors.push_back(as_seen(actor));
  for (const Sensor& sensor : sensors) {
    if (sensor.is_camera()) {
      log_.cameras.push_back({sensor.camera(), sensor.rig_from_sensor()});
      log_.cameras.back().model.name = sensor.name();
    } else {
      log_.lidars.push_back({sensor.lidar(), sensor.rig_from_sensor()});
      std::visit([&](auto& model) { model.name = sensor.name(); }, log_.lidars.back().model);
    }
  }
  std::filesystem::create_directory(folder / "images");
  std::filesystem::create_directory(folder / "sweeps");
}

void RenderedLog::add(const Frame& frame, std::size_t number, const std::string& images) {
  const std::string& name = frame.sensor().name();
  const double start_s = frame.shot().time_start_s, end_s = frame.shot().time_end_s;
  if (frame.sensor().is_camera()) {
    log_.images.push_back({name, fmt::format("images/{}_{:06d}.{}", name, number, images), start_s, end_s});
    return write_image(log_.folder / log_.images.back().file, frame.image());
  }
  log_.sweeps.push_back({name, fmt::format("sweeps/{}_{:06d}.exr", name, number), start_s, end_s});
  LidarFrame seen = frame.lidar();
  write_sweep(log_.folder / log_.sweeps.back().file,
              {std::move(seen.rays), std::move(seen.range), std::move(seen.intensity)});
}

void RenderedLog::finish() {
  sort_by_time(log_);
  write_log(log_);
}

}  // namespace simuli::cli
