// Sensors, frames, actors and labels in Python.
#include "host/apps/python/bindings.hpp"

namespace simuli::python {

std::map<std::string, Sensor> sensors_of(const SensorRig& rig, bool cameras) {
  std::map<std::string, Sensor> out;
  for (const Sensor& s : rig.sensors()) {
    if (s.is_camera() == cameras) out.emplace(s.name(), s);
  }
  return out;
}

std::map<std::string, std::vector<std::pair<double, double>>> spans_of(const FrameSpans& recorded) {
  std::map<std::string, std::vector<std::pair<double, double>>> out;
  for (const auto& [sensor, spans] : recorded) {
    for (const FrameSpan& f : spans) out[sensor].emplace_back(f.time_start_s, f.time_end_s);
  }
  return out;
}

py::list actors_as_dicts(const std::vector<Actor>& actors) {
  py::list out;
  for (const Actor& actor : actors) {
    py::list times, poses;
    for (const KeyPose& key : actor.track) {
      times.append(key.time_s);
      poses.append(array_of(key.corrected()));
    }
    py::dict one;
    one["name"] = actor.name;
    one["kind"] = actor.kind;
    one["size_m"] = py::make_tuple(actor.size_m.x(), actor.size_m.y(), actor.size_m.z());
    one["times_s"] = times;
    one["world_from_actor"] = poses;
    out.append(one);
  }
  return out;
}

py::list labels_as_dicts(const std::vector<ActorLabel>& labels, const Scene& scene, bool is_camera) {
  const auto box_of = [](const std::optional<PixelBox>& box) -> py::object {
    if (!box) return py::none();
    return py::make_tuple(box->left, box->top, box->right, box->bottom);
  };
  py::list out;
  for (const ActorLabel& label : labels) {
    const Actor& actor = scene.actors[label.actor];
    py::dict one;
    one["actor"] = label.actor + 1;
    one["name"] = actor.name;
    one["kind"] = actor.kind;
    one["time_s"] = label.time_s;
    one["size_m"] = py::make_tuple(label.size_m.x(), label.size_m.y(), label.size_m.z());
    one["world_from_actor"] = array_of(label.world_from_actor);
    one["rig_from_actor"] = array_of(label.rig_from_actor);
    one["sensor_from_actor"] = array_of(label.sensor_from_actor);
    one[is_camera ? "pixels" : "returns"] = label.rays;
    one["occlusion"] = label.occlusion;
    if (is_camera) {
      one["projected_px"] = box_of(label.projected_px);
      one["visible_px"] = box_of(label.visible_px);
      one["truncation"] = label.truncation;
    }
    out.append(one);
  }
  return out;
}

std::vector<ActorEdit> edits_of(const py::object& edits) {
  if (py::isinstance<py::sequence>(edits) && !py::isinstance<py::str>(edits)) {
    std::vector<ActorEdit> out;
    for (const py::handle edit : edits) {
      if (py::isinstance<ActorEdit>(edit)) out.push_back(edit.cast<ActorEdit>());
    }
    if (out.size() == py::len(edits)) return out;
  }
  throw Error(ErrorKind::kUsage,
              std::string("edits: found ") +
                  (py::isinstance<ActorEdit>(edits) ? "one Edit" : "something else") +
                  ", allowed a list of Edits");
}

}  // namespace simuli::python
