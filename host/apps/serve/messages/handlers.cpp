#include "host/apps/serve/messages/handlers.hpp"

#include <array>
#include <charconv>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "host/apps/serve/messages/edit_message.hpp"
#include "host/apps/serve/messages/render_message.hpp"
#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/base/version.hpp"

namespace simuli::serve {
namespace {

constexpr int kMostItems = 256;
constexpr int kMostSweeps = 16;

void need_at_most(int items, int most, const char* field) {
  if (items > most) refuse(field, fmt::format("{}", items), fmt::format("at most {}", most));
}

/// Returns the number of pixels; invalid sizes are refused later.
double pixels_of(const proto::RGBRenderRequest& request) {
  const double pixels = static_cast<double>(request.resolution_h()) * request.resolution_w();
  return pixels > kMostPixels ? 0.0 : pixels;
}

void check_limit(double pixels) {
  if (pixels <= kMostPixelsTogether) return;
  refuse("resolution",
         fmt::format("{:.0f} pixels of all pictures", pixels),
         fmt::format("at most {:.0f}", kMostPixelsTogether));
}

/// Writes the protocol version of this server.
void print_api_version(proto_common::VersionId::APIVersion& version) {
  version.set_major(0);
  version.set_minor(0);
  version.set_patch(5);
}

void add_pose(proto_common::Trajectory& trajectory, std::uint64_t time_us, const Pose& local) {
  proto_common::PoseAtTime& pose = *trajectory.add_poses();
  pose.set_timestamp_us(time_us);
  *pose.mutable_pose() = message_of(local);
}

}  // namespace

Handlers::Handlers(RenderSession& session, EgoMasks ego_masks, std::string commit, HandlerOptions options)
    : session_(session),
      ego_masks_(std::move(ego_masks)),
      commit_(std::move(commit)),
      options_(std::move(options)) {}

void Handlers::get_version(proto_common::VersionId& reply) const {
  reply.set_version_id(fmt::format("simuli {}", version()));
  reply.set_git_hash(commit_);
  print_api_version(*reply.mutable_grpc_api_version());
}

void Handlers::get_available_scenes(proto_common::AvailableScenesReturn& reply) const {
  for (const SceneSource& source : session_.sources()) reply.add_scene_ids(source.id);
}

void Handlers::get_loaded_scenes(proto::LoadedScenesReturn& reply) const {
  for (const std::string& id : session_.kept()) {
    proto::LoadedSceneEntry& entry = *reply.add_scenes();
    entry.set_scene_id(id);
    entry.set_loaded_instance_count(1);
    entry.set_reusable_instance_count(1);  // any number of callers may share it
  }
  reply.set_loaded_instance_capacity(session_.cache_size());
}

void Handlers::get_available_cameras(const Call& call,
                                     const proto::AvailableCamerasRequest& request,
                                     proto::AvailableCamerasReturn& reply) const {
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  for (const Sensor& sensor : scene->cameras()) {
    proto::AvailableCamera& camera = *reply.add_available_cameras();
    *camera.mutable_intrinsics() = spec_of(sensor.camera());
    *camera.mutable_rig_to_camera() = message_of(sensor.rig_from_sensor());
    camera.set_logical_id(sensor.name());
  }
}

void Handlers::get_available_trajectories(const Call& call,
                                          const proto::AvailableTrajectoriesRequest& request,
                                          proto::AvailableTrajectoriesReturn& reply) const {
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  if (scene->world_from_rig().poses().empty()) return;
  proto_common::Trajectory& trajectory = *reply.add_available_trajectories()->mutable_trajectory();
  for (const TimedPose& pose : scene->world_from_rig().poses()) {
    add_pose(trajectory, scene->microseconds(pose.time_s), scene->local(pose.pose));
  }
}

void Handlers::get_available_ego_masks(proto::AvailableEgoMasksReturn& reply) const {
  for (const EgoMaskId& id : ego_masks_.ids()) {
    proto::EgoMaskId& mask = *reply.add_ego_mask_metadata()->mutable_ego_mask_id();
    mask.set_camera_logical_id(id.camera);
    mask.set_rig_config_id(id.rig);
  }
}

void Handlers::get_dynamic_objects(const Call& call,
                                   const proto::AvailableDynamicObjectsRequest& request,
                                   proto::AvailableDynamicObjectsReturn& reply) const {
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  for (const Actor& actor : scene->scene().actors) {
    proto::DynamicObjectTrack& object = *reply.add_dynamic_objects();
    object.set_id(actor.name);
    object.set_semantic_class(actor.kind);
    object.set_asset_id(actor.name);
    object.mutable_object_size()->set_size_x(static_cast<float>(actor.size_m.x()));
    object.mutable_object_size()->set_size_y(static_cast<float>(actor.size_m.y()));
    object.mutable_object_size()->set_size_z(static_cast<float>(actor.size_m.z()));
    for (const KeyPose& key : actor.track) {
      add_pose(*object.mutable_trajectory(), scene->microseconds(key.time_s), scene->local(key.corrected()));
    }
  }
}

void Handlers::edit_assets(const Call& call,
                           const proto::EditAssetsRequest& request,
                           proto::EditAssetsResponse& reply) const {
  if (!options_.allows_edits) {
    throw Refusal(RefusalKind::kPrecondition,
                  "edit_assets: found a server without --enable-editing-actors, allowed one with it");
  }
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  try {
    session_.edit(scene->id(), edit_of(*scene, request, options_.most_more_particles), call.is_given_up);
    reply.set_success(true);
  } catch (...) {
    const Refusal refusal = refusal_of(std::current_exception());
    if (refusal.kind() == RefusalKind::kCancelled || refusal.kind() == RefusalKind::kInternal) throw;
    reply.set_message(refusal.what());
  }
}

void Handlers::restore_model_parameters(const Call& call,
                                        const proto::RestoreModelParametersRequest& request) const {
  session_.restore(request.scene_id(), call.is_given_up);
}

void Handlers::get_external_asset_objects(const Call& call,
                                          const proto::ExternalAssetObjectsRequest& request,
                                          proto::ExternalAssetObjectsReturn& reply) const {
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  for (const std::string& id : scene->external()) reply.add_track_ids(id);
}

void Handlers::get_server_config(proto::ServerConfig& reply) const {
  auto& config = *reply.mutable_server_config();
  for (const auto& [key, value] : options_.reported) config[key] = value;
  config["version"] = version();
  config["device"] = session_.devices();
  config["cache-size"] = fmt::format("{}", session_.cache_size());
  config["enable-editing-actors"] = options_.allows_edits ? "true" : "false";
}

/// A picture in progress.
struct Handlers::Picture {
  RenderSession::ScenePtr scene = {};
  PictureCode code = {};
  std::optional<FrameJob> job = {};
  Image under_mask = {};
  std::exception_ptr error = {};
};

/// Returns the encoded bytes of a rendered picture. Call it once.
std::string Handlers::encoded(Picture& picture) const {
  if (picture.error) std::rethrow_exception(picture.error);
  const Stopwatch watch;
  std::string bytes;
  if (picture.code.ego_mask) {
    ego_masks_.lay_over(picture.under_mask, *picture.code.ego_mask);
    bytes = serve::encoded(picture.under_mask, picture.code);
  } else {
    const Camera& camera = picture.job->sensor.camera();
    bytes = serve::encoded(std::move(picture.job->bytes), camera.width, camera.height, picture.code);
  }
  metrics().add_time(RequestStage::kEncoding, watch.seconds());
  return bytes;
}

Handlers::Picture Handlers::prepare(const Call& call, const proto::RGBRenderRequest& request) const {
  Picture picture;
  picture.code = picture_code(request, ego_masks_);
  picture.scene = session_.open(request.scene_id(), call.is_given_up);
  const ServedScene& scene = *picture.scene;
  const Camera camera = requested_camera(scene, request);
  const FrameMessage frame{
      request.frame_start_us(), request.frame_end_us(), request.sensor_pose(), request.dynamic_objects()};
  picture.job = FrameJob{Sensor(camera), camera_shot(scene, frame, camera), {}, order_of(picture.code)};
  return picture;
}

/// Renders the pictures of each scene together, regardless of their order.
void Handlers::render(const Call& call, std::span<Picture> pictures) const {
  std::vector<bool> done(pictures.size());
  for (std::size_t first = 0; first < pictures.size(); ++first) {
    if (done[first] || !pictures[first].job) continue;
    ServedScene& scene = *pictures[first].scene;
    std::vector<FrameJob> jobs;
    std::vector<Picture*> of_jobs;
    for (std::size_t i = first; i < pictures.size(); ++i) {
      Picture& picture = pictures[i];
      if (!picture.job || picture.scene.get() != &scene) continue;
      done[i] = true;
      if (picture.code.ego_mask) {
        picture.job->take = [&picture](const Frame& frame) { picture.under_mask = frame.image(); };
      }
      jobs.push_back(std::move(*picture.job));
      of_jobs.push_back(&picture);
    }
    session_.render(scene, jobs, call.is_given_up);
    for (std::size_t k = 0; k < jobs.size(); ++k) {
      of_jobs[k]->error = jobs[k].error;
      of_jobs[k]->job = std::move(jobs[k]);
    }
  }
}

void Handlers::render_rgb(const Call& call,
                          const proto::RGBRenderRequest& request,
                          proto::RGBRenderReturn& reply) const {
  std::array<Picture, 1> one{prepare(call, request)};
  render(call, one);
  throw_if_cancelled(call.is_given_up);
  reply.set_image_bytes(encoded(one[0]));
}

void Handlers::batch_render_rgb(const Call& call,
                                const proto::BatchRGBRenderRequest& request,
                                proto::BatchRGBRenderReturn& reply) const {
  need_at_most(request.items_size(), kMostItems, "items");
  double pixels = 0.0;
  for (const auto& item : request.items()) pixels += pixels_of(item.request());
  check_limit(pixels);
  std::vector<Picture> pictures(static_cast<std::size_t>(request.items_size()));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    throw_if_cancelled(call.is_given_up);
    try {
      pictures[i] = prepare(call, request.items(static_cast<int>(i)).request());
    } catch (...) {
      pictures[i].error = std::current_exception();
    }
  }
  render(call, pictures);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    throw_if_cancelled(call.is_given_up);
    auto& item = *reply.add_items();
    item.set_camera_name(request.items(static_cast<int>(i)).camera_name());
    try {
      item.mutable_result()->set_image_bytes(encoded(pictures[i]));
      item.set_success(true);
    } catch (...) {
      item.clear_result();
      item.set_error_message(refusal_of(std::current_exception()).what());
    }
  }
}

void Handlers::render_lidar(const Call& call,
                            const proto::LidarRenderRequest& request,
                            proto::LidarRenderReturn& reply) const {
  const ReturnFilter filter = return_filter(request);
  const std::string name = call.lidar.empty() ? lidar_name(request.lidar_config()) : call.lidar;
  const auto scene = session_.open(request.scene_id(), call.is_given_up);
  const Sensor lidar = scene->lidar(name);
  const FrameMessage frame{
      request.frame_start_us(), request.frame_end_us(), request.sensor_pose(), request.dynamic_objects()};
  LidarFrame sweep;
  const Shot shot = lidar_shot(*scene, frame);
  std::array<FrameJob, 1> job{
      FrameJob{lidar, shot, [&](const Frame& rendered) { sweep = take_sweep(rendered, filter); }}};
  session_.render(*scene, job, call.is_given_up);
  if (job[0].error) std::rethrow_exception(job[0].error);
  throw_if_cancelled(call.is_given_up);
  print_points(lidar.lidar(), sweep, shot, reply);
}

void Handlers::render_aggregated(const Call& call,
                                 const proto::AggregatedRenderRequest& request,
                                 proto::AggregatedRenderReturn& reply) const {
  need_at_most(request.rgb_requests_size(), kMostItems, "rgb_requests");
  need_at_most(request.lidar_requests_size(), kMostSweeps, "lidar_requests");
  double pixels = 0.0;
  for (const auto& rgb : request.rgb_requests()) pixels += pixels_of(rgb);
  check_limit(pixels);
  std::vector<Picture> pictures;
  for (const auto& rgb : request.rgb_requests()) pictures.push_back(prepare(call, rgb));
  render(call, pictures);
  for (Picture& picture : pictures) {
    throw_if_cancelled(call.is_given_up);
    reply.add_rgb_returns()->set_image_bytes(encoded(picture));
  }
  for (const auto& lidar : request.lidar_requests()) render_lidar(call, lidar, *reply.add_lidar_returns());
}

}  // namespace simuli::serve
