#pragma once
// Views of one scene on one device, rendered on request for any number of pages.
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

/// Calls may come from any thread; renders are serialised.
class ViewSession : public ViewAnswers {
 public:
  /// `file` may have empty sets before the training begins; views are refused then. `source`: for command();
  /// empty for a scene in training.
  ViewSession(const Globals& globals, SceneFile file, ViewSource source = {});

  /// Replaces the displayed scene.
  void show(Scene scene);
  void set_progress(const ViewProgress& progress);
  /// Returns the seconds since the last request of a page; infinity before the first.
  [[nodiscard]] double idle_s() const;

  [[nodiscard]] std::string describe() const override;
  /// Also contains ViewProgress; the version changes with every show() and every added actor.
  [[nodiscard]] std::string progress() const override;
  /// Throws Error{kUsage} for an unknown sensor, quality or actor, Error{kInput} for a scene without such
  /// particles.
  [[nodiscard]] std::string picture(const ViewRequest& request) override;
  [[nodiscard]] std::string sweep(const ViewRequest& request) override;
  /// Of a camera's pixel: median distance along the ray and depth along z in m, the end point (scene frame),
  /// the opacity up to it, the colour, the actor, the support.
  [[nodiscard]] std::string probe(const ViewRequest& request) override;

  /// Duplicates the actor {"actor": NAME} for all pages until the session ends. Returns JSON with the copy's
  /// name. Throws Error{kUsage} for unknown actors and during a training.
  [[nodiscard]] std::string duplicate(const std::string& json) override;
  /// Adds the splats of a file with these contents as an actor, 10 m ahead of the rig at that time. Returns
  /// JSON: its name, derived from the file's, its offset from the position of `--add`, and a note on particles
  /// left out, or "". Errors as in duplicate() and read_splats().
  [[nodiscard]] std::string add(const std::string& file_name,
                                const std::string& bytes,
                                double time_s) override;
  static constexpr std::size_t kMostAdded = 64;  // actors
  /// Returns JSON: command_of() the request. Throws Error{kUsage} also for a scene without a folder.
  [[nodiscard]] std::string command(const ViewRequest& request) const override;

 private:
  /// Changes the scene for all pages, except during a training; `how` returns the equivalent command-line
  /// option.
  void change(const std::function<std::string(Scene&)>& how);
  /// Returns the request's shot of a sensor or of a free camera.
  [[nodiscard]] Shot shot_of(const ViewRequest& request, const Sensor& sensor) const;
  /// Returns the camera and the shot of a picture. Throws Error{kUsage} for too large pictures.
  [[nodiscard]] std::pair<Sensor, Shot> still_of(const ViewRequest& request) const;
  /// A sweep in the scene's frame.
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
  mutable std::mutex mutex_;  // protects the members below, except the progress
  SceneFile file_;            // without its scene, which is on the device
  RecordedViews recorded_;    // of the scene's cameras
  SensorRig rig_;
  SceneOnDevice scene_;
  std::optional<SupportOnDevice> support_;  // created on first use
  ActorCopies copies_;
  mutable std::mutex progress_mutex_;
  ViewProgress progress_;
  std::uint64_t version_ = 0;
  ViewSource source_;
  std::vector<std::string> added_, added_names_;  // command-line options and names of added actors
  double requested_s_;
};

}  // namespace simuli::cli
