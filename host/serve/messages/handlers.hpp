#pragma once
// The calls of the service, without a network: a message in, a message out.
#include <cstddef>
#include <span>
#include <string>

#include "host/serve/messages/camera_message.hpp"
#include "host/serve/session/hoods.hpp"
#include "host/serve/session/render_session.hpp"

namespace simuli::serve {

/// What a call brings beside its message.
struct Call {
  IsGivenUp is_given_up = never_given_up;
  std::string lidar = {};  // by name, instead of the request's type: of the scene, or built in
};

/// Safe to use from any thread. What a call throws is what refusal_of() knows; its reply is not to be used
/// then.
class Handlers {
 public:
  /// `commit`: of the program, may be empty. The session outlives this.
  Handlers(RenderSession& session, Hoods hoods, std::string commit);

  void get_version(proto_common::VersionId& reply) const;
  void get_available_scenes(proto_common::AvailableScenesReturn& reply) const;
  void get_loaded_scenes(proto::LoadedScenesReturn& reply) const;
  void get_available_cameras(const Call& call,
                             const proto::AvailableCamerasRequest& request,
                             proto::AvailableCamerasReturn& reply) const;
  void get_available_trajectories(const Call& call,
                                  const proto::AvailableTrajectoriesRequest& request,
                                  proto::AvailableTrajectoriesReturn& reply) const;
  void get_available_ego_masks(proto::AvailableEgoMasksReturn& reply) const;
  void get_dynamic_objects(const Call& call,
                           const proto::AvailableDynamicObjectsRequest& request,
                           proto::AvailableDynamicObjectsReturn& reply) const;

  void render_rgb(const Call& call,
                  const proto::RGBRenderRequest& request,
                  proto::RGBRenderReturn& reply) const;
  /// What is wrong with an item is told in its place.
  void batch_render_rgb(const Call& call,
                        const proto::BatchRGBRenderRequest& request,
                        proto::BatchRGBRenderReturn& reply) const;
  void render_lidar(const Call& call,
                    const proto::LidarRenderRequest& request,
                    proto::LidarRenderReturn& reply) const;
  void render_aggregated(const Call& call,
                         const proto::AggregatedRenderRequest& request,
                         proto::AggregatedRenderReturn& reply) const;

 private:
  struct Picture;
  [[nodiscard]] Picture prepare(const Call& call, const proto::RGBRenderRequest& request) const;
  void render(const Call& call, std::span<Picture> pictures) const;

  RenderSession& session_;
  Hoods hoods_;
  std::string commit_;
};

}  // namespace simuli::serve
