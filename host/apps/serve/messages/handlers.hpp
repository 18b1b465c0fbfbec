#pragma once
// The calls of the service, without a network: a message in, a message out.
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host/apps/serve/messages/camera_message.hpp"
#include "host/apps/serve/session/ego_masks.hpp"
#include "host/apps/serve/session/render_session.hpp"

namespace simuli::serve {

/// What a call brings beside its message.
struct Call {
  IsGivenUp is_given_up = never_given_up;
  std::string lidar = {};  // by name, instead of the request's type: of the scene, or built in
};

struct HandlerOptions {
  bool allows_edits = false;                     // by edit_assets: they are everybody's
  std::int64_t most_more_particles = 1'000'000;  // than twice those of the scene, by edits
  std::map<std::string, std::string> told = {};  // by get_server_config
};

/// Safe to use from any thread. What a call throws is what refusal_of() knows; its reply is not to be used
/// then.
class Handlers {
 public:
  /// `commit`: of the program, may be empty. The session outlives this.
  Handlers(RenderSession& session, EgoMasks ego_masks, std::string commit, HandlerOptions options = {});

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
  /// Of the scene, for all clients, until restore_model_parameters. What is wrong with the edits is told in
  /// the reply, and then nothing has changed. Refusal{kPrecondition} where HandlerOptions don't allow it.
  void edit_assets(const Call& call,
                   const proto::EditAssetsRequest& request,
                   proto::EditAssetsResponse& reply) const;
  void restore_model_parameters(const Call& call, const proto::RestoreModelParametersRequest& request) const;
  /// Actors with the particles of another one.
  void get_external_asset_objects(const Call& call,
                                  const proto::ExternalAssetObjectsRequest& request,
                                  proto::ExternalAssetObjectsReturn& reply) const;
  void get_server_config(proto::ServerConfig& reply) const;

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

  /// What was answered under the same number holds for the same request.
  [[nodiscard]] std::uint64_t edition() const { return session_.edition(); }
  /// What is counted, and what there is at the moment.
  [[nodiscard]] Metrics& metrics() const { return session_.metrics(); }
  [[nodiscard]] std::vector<Gauge> gauges() const { return session_.gauges(); }

 private:
  struct Picture;
  [[nodiscard]] std::string encoded(Picture& picture) const;
  [[nodiscard]] Picture prepare(const Call& call, const proto::RGBRenderRequest& request) const;
  void render(const Call& call, std::span<Picture> pictures) const;

  RenderSession& session_;
  EgoMasks ego_masks_;
  std::string commit_;
  HandlerOptions options_;
};

}  // namespace simuli::serve
