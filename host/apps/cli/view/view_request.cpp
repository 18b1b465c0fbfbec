#include "host/apps/cli/view/view_request.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::cli {
namespace {

ViewLayer layer_named(const std::string& name, const std::string& field) {
  if (name == "colour") return ViewLayer::kColour;
  if (name == "depth") return ViewLayer::kDepth;
  if (name == "opacity") return ViewLayer::kOpacity;
  if (name == "unseen") return ViewLayer::kUnseen;
  if (name == "support") return ViewLayer::kSupport;
  throw_input_error("request", field, '"' + name + '"', "colour, depth, opacity, unseen, support");
}

}  // namespace

std::vector<ActorEdit> ViewRequest::edits() const {
  std::vector<ActorEdit> edits;
  for (const auto& [name, how] : retimed) edits.push_back({name, ActorEdit::Retime{how[0], how[1]}});
  for (const auto& [name, by_m] : moved) edits.push_back({name, ActorEdit::Move{by_m}});
  for (const auto& [name, by_deg] : turned_deg) edits.push_back({name, ActorEdit::Turn{by_deg * kDegree}});
  for (const std::string& name : removed) edits.push_back({name, ActorEdit::Remove{}});
  return edits;
}

bool ViewRequest::is_as_recorded() const {
  return rig_shift_m.isZero() && yaw_rad == 0.0 && pitch_rad == 0.0 && !scene_from_camera &&
         layer == ViewLayer::kColour && edits().empty();
}

ViewRequest parse_view_request(const std::string& json) {
  constexpr double kFarthest_m = 1e6;
  return read_json_text(json, "request", [](JsonObject& o) {
    ViewRequest r;
    r.sensor = o.text("sensor");
    r.quality = o.text("quality");
    r.time_s = o.number("time_s");
    r.width = static_cast<int>(o.integer("width", ViewRequest::kNarrowest_px, ViewRequest::kWidest_px));
    r.rig_shift_m = {o.number("forward_m", -kFarthest_m, kFarthest_m),
                     o.number("left_m", -kFarthest_m, kFarthest_m),
                     o.number("up_m", -kFarthest_m, kFarthest_m)};
    r.yaw_rad = o.number("yaw_rad", -1e3, 1e3);
    r.pitch_rad = o.number("pitch_rad", -1e3, 1e3);
    if (o.has("scene_from_camera")) {
      r.scene_from_camera = o.object("scene_from_camera", [](JsonObject& p) {
        const Eigen::Vector4d q = p.vector<4>("q");
        if (!(q.norm() > 1e-6)) throw_input_error("request", p.field("q"), "zero", "a quaternion");
        return Pose{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), p.vector<3>("t")};
      });
    }
    if (o.has("height")) {
      if (!r.scene_from_camera) {
        throw_input_error(
            "request", o.field("height"), "one of a rig's camera", "one with scene_from_camera");
      }
      r.height = static_cast<int>(o.integer("height", ViewRequest::kNarrowest_px, ViewRequest::kWidest_px));
    }
    if (o.has("pixel")) {
      const Eigen::Vector2d at = o.vector<2>("pixel");
      if (at.minCoeff() < 0.0 || at.maxCoeff() > 1.0) {
        throw_input_error("request", o.field("pixel"), "a place outside of the picture", "0 to 1, both");
      }
      r.pixel = at;
    }
    if (o.has("points")) r.points = o.text("points");
    if (o.has("sweeps")) r.sweeps = static_cast<int>(o.integer("sweeps", 1, ViewRequest::kMostSweeps));
    if (o.has("layer")) r.layer = layer_named(o.text("layer"), o.field("layer"));
    if (o.has("lossless")) r.lossless = o.boolean("lossless");
    const Json& removed = o.get("removed");
    const auto is_name = [](const Json& name) { return name.is_string(); };
    if (!removed.is_array() || !std::all_of(removed.begin(), removed.end(), is_name)) {
      throw_input_error("request", "removed", removed.type_name(), "an array of actors' names");
    }
    for (const Json& name : removed) r.removed.push_back(name.get<std::string>());
    o.object("moved", [&](JsonObject& moved) {
      for (const auto& item : o.get("moved").items()) r.moved[item.key()] = moved.vector<3>(item.key());
    });
    if (o.has("turned_deg")) {
      o.object("turned_deg", [&](JsonObject& turned) {
        for (const auto& item : o.get("turned_deg").items()) {
          r.turned_deg[item.key()] = turned.number(item.key(), -1e6, 1e6);
        }
      });
    }
    if (o.has("retimed")) {
      o.object("retimed", [&](JsonObject& retimed) {
        for (const auto& item : o.get("retimed").items()) {
          r.retimed[item.key()] = retimed.vector<2>(item.key());
        }
      });
    }
    return r;
  });
}

}  // namespace simuli::cli
