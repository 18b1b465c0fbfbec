#pragma once
// What the viewer shows, rendered on request: one scene on one device, for any number of pages.
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/draw/unseen.hpp"
#include "host/apps/cli/view/live_page.hpp"
#include "host/apps/cli/view/view_answers.hpp"
#include "host/apps/cli/view/view_command.hpp"
#include "host/apps/cli/view/view_request.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/render/scene/view.hpp"
#include "host/device/support/support.hpp"
#include "io/scene/sensor_rig.hpp"

namespace simuli::cli {

/// Calls may come from any thread; renders wait for each other.
class ViewSession : public ViewAnswers {
 public:
  /// `file` may have empty sets, of a training that has not begun: views are then refused.
  /// `source`: for command(); empty where a training makes the scene.
  ViewSession(const Globals& globals, SceneFile file, ViewSource source = {});

  /// From now on this scene is shown.
  void show(Scene scene);
  void set_progress(const ViewProgress& progress);
  /// Seconds since a page last asked for anything; infinite before.
  [[nodiscard]] double idle_s() const;

  [[nodiscard]] std::string describe() const override;
  /// Also ViewProgress; the number changes with every show() and every actor that is added.
  [[nodiscard]] std::string progress() const override;
  /// Error{kUsage} for an unknown sensor, quality or actor, Error{kInput} for a scene without such particles.
  [[nodiscard]] std::string picture(const ViewRequest& request) override;
  [[nodiscard]] std::string sweep(const ViewRequest& request) override;
  /// Of a camera: median distance along the ray and depth along z, m, where it ends (scene frame), how much of
  /// the light ends before, the colour, whose it is, how well that is known.
  [[nodiscard]] std::string probe(const ViewRequest& request) override;

  /// A second one of the actor that the request, {"actor": NAME}, names: for all pages, until the session
  /// ends. JSON: its name. Error{kUsage} for actors that are not there, and while a training runs.
  [[nodiscard]] std::string duplicate(const std::string& json) override;
  /// The splats of a file whose contents these are as an actor, which stands 10 m ahead of the rig at that
  /// time. JSON: its name, after the file's, how far it is moved from where `--add` puts it, and what was left
  /// out, or "". Errors as duplicate() and read_splats().
  [[nodiscard]] std::string add(const std::string& file_name,
                                const std::string& bytes,
                                double time_s) override;
  static constexpr std::size_t kMostAdded = 64;  // actors
  /// JSON: command_of() the request. Error{kUsage} also for a scene without a name on disk.
  [[nodiscard]] std::string command(const ViewRequest& request) const override;

 private:
  /// Changes the scene for all pages, while no training does; `how` returns the option that does the same.
  void change(const std::function<std::string(Scene&)>& how);
  /// The request's shot of that sensor; a camera's may be a free one.
  [[nodiscard]] Shot shot_of(const ViewRequest& request, const Sensor& sensor) const;
  /// The camera of a picture, and its shot. Error{kUsage} for pictures that are too large.
  [[nodiscard]] std::pair<Sensor, Shot> still_of(const ViewRequest& request) const;
  /// A sweep, in the scene's frame.
  struct Swept {
    Shot in_scene;
    std::vector<ActorView> actors;
    std::vector<float> points;  // kPointValues each
    std::size_t rays = 0;
    double render_ms = 0.0;
  };
  [[nodiscard]] Swept swept(const ViewRequest& request);
  void touch();

  Globals globals_;
  mutable std::mutex mutex_;  // of everything below but the progress
  SceneFile file_;            // without its scene, which is on the device
  RecordedViews recorded_;    // of its cameras
  SensorRig rig_;
  SceneOnDevice scene_;
  std::optional<SupportOnDevice> support_;  // when first asked for
  ActorCopies copies_;
  mutable std::mutex progress_mutex_;
  ViewProgress progress_;
  std::uint64_t version_ = 0;
  ViewSource source_;
  std::vector<std::string> added_, added_names_;  // options, actors
  double asked_s_;
};

}  // namespace simuli::cli
