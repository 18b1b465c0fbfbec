#pragma once
// Calls of the service without the network: a request message in, a reply message out.
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

/// Context of a call besides its message.
struct Call {
  IsGivenUp is_given_up = never_given_up;
  std::string lidar = {};  // name of a LiDAR, of the scene or built in, that replaces the request's type
};

struct HandlerOptions {
  bool allows_edits = false;                     // by edit_assets; they apply to all clients
  std::int64_t most_more_particles = 1'000'000;  // limit of edits: particles beyond twice those of the scene
  std::map<std::string, std::string> reported = {};  // reported by get_server_config
};

/// Safe to use from any thread. A call throws exceptions that refusal_of() converts; its reply is invalid then.
class Handlers {
 public:
  /// `commit`: of the program, may be empty. The session must outlive this object.
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
  /// Edits the scene for all clients until restore_model_parameters. The reply lists invalid edits; then
  /// nothing has changed. Throws Refusal{kPrecondition} unless HandlerOptions allow it.
  void edit_assets(const Call& call,
                   const proto::EditAssetsRequest& request,
                   proto::EditAssetsResponse& reply) const;
  void restore_model_parameters(const Call& call, const proto::RestoreModelParametersRequest& request) const;
  /// Lists actors with another actor's particles.
  void get_external_asset_objects(const Call& call,
                                  const proto::ExternalAssetObjectsRequest& request,
                                  proto::ExternalAssetObjectsReturn& reply) const;
  void get_server_config(proto::ServerConfig& reply) const;

  void render_rgb(const Call& call,
                  const proto::RGBRenderRequest& request,
                  proto::RGBRenderReturn& reply) const;
  /// The reply reports errors of single items.
  void batch_render_rgb(const Call& call,
                        const proto::BatchRGBRenderRequest& request,
                        proto::BatchRGBRenderReturn& reply) const;
  void render_lidar(const Call& call,
                    const proto::LidarRenderRequest& request,
                    proto::LidarRenderReturn& reply) const;
  void render_aggregated(const Call& call,
                         const proto::AggregatedRenderRequest& request,
                         proto::AggregatedRenderReturn& reply) const;

  /// Replies under the same number are valid for equal requests.
  [[nodiscard]] std::uint64_t edition() const { return session_.edition(); }
  /// Counters and gauges.
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
