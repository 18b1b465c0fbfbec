// C API of frames.
#include <limits>

#include "host/apps/api/c_handles.hpp"
#include "host/device/render/outputs/flow.hpp"
#include "host/device/render/scene/frame_state.hpp"

using namespace simuli;
using namespace simuli::capi;

namespace {

/// Converts [3][rays] to [rays][3].
std::vector<float> interleaved(const RayResults& results) {
  std::vector<float> out;
  out.reserve(3 * results.rays);
  for (std::size_t i = 0; i < results.rays; ++i) {
    for (const std::vector<float>& channel : results.feature) out.push_back(channel[i]);
  }
  return out;
}

template <class F>
std::vector<float> each(const RayResults& results, F&& value) {
  std::vector<float> out(results.rays);
  for (std::size_t i = 0; i < results.rays; ++i) out[i] = value(i);
  return out;
}

/// Converts a request without the scene's options and the shot's edits.
FrameRequest request_of(const simuli_request* request, std::size_t rays) {
  FrameRequest out{.camera_median = true};
  if (request == nullptr) return out;
  out.graded = request->is_ungraded == 0;
  out.actors = request->with_actors != 0;
  if (request->rays == nullptr) return out;
  need_length("ray_count", request->ray_count, rays);
  for (std::size_t i = 0; i < rays; ++i) out.rays.push_back(request->rays[i] != 0);
  return out;
}

std::vector<float> values_of(const Frame& frame, simuli_quantity quantity) {
  switch (quantity) {
    case SIMULI_RGB:
      return frame.image().data;
    case SIMULI_RANGE:
      return frame.lidar().range;
    case SIMULI_INTENSITY:
      return frame.lidar().intensity;
    case SIMULI_DROP:
      return frame.lidar().drop;
    case SIMULI_ACTORS: {
      const std::vector<std::uint32_t> actors = frame.actors();
      return {actors.begin(), actors.end()};
    }
    default:
      break;
  }
  const RayResults& r = frame.results();
  switch (quantity) {
    case SIMULI_FEATURE:
      return interleaved(r);
    case SIMULI_OPACITY:
      return each(r, [&](std::size_t i) { return 1.0F - r.transmittance[i]; });
    case SIMULI_DISTANCE:
      return each(r, [&](std::size_t i) { return r.expected_distance(i); });
    case SIMULI_MEDIAN:
      return r.median;
    case SIMULI_TRANSMITTANCE:
      return r.transmittance;
    case SIMULI_DISTANCE_SUM:
      return r.distance;
    default:
      break;
  }
  throw Error(ErrorKind::kUsage,
              fmt::format("quantity: found {}, allowed {} to {}",
                          static_cast<int>(quantity),
                          static_cast<int>(SIMULI_RGB),
                          static_cast<int>(SIMULI_ACTORS)));
}

simuli_label label_of(const ActorLabel& label) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  simuli_label out{label.actor,
                   label.time_s,
                   {label.size_m.x(), label.size_m.y(), label.size_m.z()},
                   to_c(label.world_from_actor),
                   to_c(label.rig_from_actor),
                   to_c(label.sensor_from_actor),
                   label.rays,
                   label.occlusion.value_or(kNone),
                   label.truncation,
                   {},
                   {}};
  const auto put = [](const PixelBox& box, double* px) {
    px[0] = box.left, px[1] = box.top, px[2] = box.right, px[3] = box.bottom;
  };
  constexpr PixelBox kNowhere{kNone, kNone, kNone, kNone};
  put(label.projected_px.value_or(kNowhere), out.projected_px);
  put(label.visible_px.value_or(kNowhere), out.visible_px);
  return out;
}

}  // namespace

extern "C" {

simuli_status simuli_render(simuli_scene* scene,
                            const char* name,
                            const simuli_shot* shot,
                            const simuli_request* request,
                            simuli_frame** frame) {
  return guarded([&] {
    simuli_frame*& out = need(frame, "frame");
    const Sensor sensor = sensor_of(need(scene, "scene"), name);
    Shot wanted = shot_of(need(shot, "shot"));
    FrameRequest requested = request_of(request, sensor.ray_count());
    requested.options = scene->options;
    for (std::size_t i = 0; request != nullptr && i < request->edit_count; ++i) {
      wanted.edits.push_back(edit_of((&need(request->edits, "edits"))[i]));
    }
    out = new simuli_frame{scene->on_device.render(sensor, wanted, requested)};
  });
}

void simuli_frame_close(simuli_frame* frame) { delete frame; }

simuli_status simuli_frame_is_ready(const simuli_frame* frame, int* is_ready) {
  return guarded([&] { need(is_ready, "is_ready") = need(frame, "frame").frame.is_ready() ? 1 : 0; });
}

simuli_status simuli_frame_wait(const simuli_frame* frame) {
  return guarded([&] { need(frame, "frame").frame.wait(); });
}

simuli_status simuli_frame_fetch(const simuli_frame* frame) {
  return guarded([&] { need(frame, "frame").frame.fetch(); });
}

simuli_status simuli_frame_values(const simuli_frame* frame,
                                  simuli_quantity quantity,
                                  float* values,
                                  size_t count) {
  return guarded([&] {
    const std::vector<float> found = values_of(need(frame, "frame").frame, quantity);
    need_length("count", count, found.size());
    std::copy(found.begin(), found.end(), &need(values, "values"));
  });
}

simuli_status simuli_frame_points(const simuli_frame* frame, double* xyz, size_t count) {
  return guarded([&] {
    const std::vector<Eigen::Vector3d> points = need(frame, "frame").frame.points();
    need_length("count", count, 3 * points.size());
    double* to = &need(xyz, "xyz");
    for (const Eigen::Vector3d& p : points) to = std::copy(p.begin(), p.end(), to);
  });
}

simuli_status simuli_frame_support(simuli_scene* scene,
                                   const simuli_frame* frame,
                                   float* values,
                                   size_t count) {
  return guarded([&] {
    simuli_scene& of = need(scene, "scene");
    const Frame& requested = need(frame, "frame").frame;
    need_length("count", count, requested.sensor().ray_count());
    FrameAccess::need_of(requested, of.on_device.scene(), "support");
    if (!of.support) of.support.emplace(of.on_device.device(), of.file.support);
    const std::vector<float> found = of.support->of(requested, of.on_device.scene(), of.copies);
    std::copy(found.begin(), found.end(), &need(values, "values"));
  });
}

simuli_status simuli_frame_labels(
    simuli_scene* scene, const simuli_frame* frame, simuli_label* labels, size_t room, size_t* count) {
  return guarded([&] {
    simuli_scene& of = need(scene, "scene");
    const Scene& current = of.on_device.scene();
    const Frame& requested = need(frame, "frame").frame;
    if (room < current.actors.size()) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("room: found {}, allowed at least {}", room, current.actors.size()));
    }
    if (!of.labels) of.labels.emplace(of.on_device.device(), borrowed(current), of.options);
    const std::vector<ActorLabel> found = of.labels->of(requested);
    if (!found.empty()) std::transform(found.begin(), found.end(), &need(labels, "labels"), label_of);
    need(count, "count") = found.size();
  });
}

simuli_status simuli_frame_flow(const simuli_scene* scene,
                                const simuli_frame* frame,
                                const simuli_frame* to,
                                float* pixels,
                                float* points,
                                size_t count) {
  return guarded([&] {
    const Frame& requested = need(frame, "frame").frame;
    const Flow flow = flow_of(requested, need(scene, "scene").on_device.scene(), need(to, "to").frame.shot());
    need_length("count", count, flow.pixels.data.size());
    if (pixels != nullptr) std::copy(flow.pixels.data.begin(), flow.pixels.data.end(), pixels);
    if (points != nullptr) std::copy(flow.points.data.begin(), flow.points.data.end(), points);
  });
}

simuli_status simuli_frame_gradients(simuli_scene* scene,
                                     const simuli_frame* frame,
                                     const float* feature,
                                     const float* transmittance,
                                     const float* distance_sum,
                                     float* values,
                                     size_t count) {
  return guarded([&] {
    const Frame& of = need(frame, "frame").frame;
    const std::size_t rays = of.sensor().ray_count();
    RayGradients given;
    for (std::size_t c = 0; c < 3 && feature != nullptr; ++c) {
      for (std::size_t i = 0; i < rays; ++i) given.feature[c].push_back(feature[3 * i + c]);
    }
    if (transmittance != nullptr) given.transmittance.assign(transmittance, transmittance + rays);
    if (distance_sum != nullptr) given.distance.assign(distance_sum, distance_sum + rays);
    const Eigen::MatrixXf gradients = need(scene, "scene").on_device.gradients(of, given);
    need_length("count", count, static_cast<std::size_t>(gradients.size()));
    std::copy(gradients.data(), gradients.data() + gradients.size(), &need(values, "values"));
  });
}

}  // extern "C"
