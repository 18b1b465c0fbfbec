#pragma once
// Handle types of simuli.h and error reporting, for the sources of the C API.
#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/api/simuli.h"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/device/render/outputs/labels.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/support/support.hpp"
#include "io/scene/sensor_rig.hpp"

struct simuli_device {
  simuli::Device device;
  std::string name;
};

struct simuli_scene {
  simuli::SensorRig rig;
  simuli::SceneFile file;  // without its scene, which is in on_device
  simuli::RenderOptions options;
  simuli::SceneOnDevice on_device;
  simuli::ActorCopies copies;                      // duplicated actors and their originals
  std::optional<simuli::SupportOnDevice> support;  // created on first use
  std::optional<simuli::LabelsOnDevice> labels;    // created on first use, for the current scene and options
  std::string notes;                               // of a splat file
};

struct simuli_frame {
  simuli::Frame frame;
};

namespace simuli::capi {

/// Returns the text of simuli_error() of this thread.
[[nodiscard]] std::string& last_error();

/// Runs f and converts each exception to a status.
template <class F>
simuli_status guarded(F&& f) noexcept {
  const auto fail = [](simuli_status status, const std::string& what) {
    try {
      last_error() = what;
    } catch (...) {
      last_error().clear();
    }
    return status;
  };
  try {
    f();
    return SIMULI_OK;
  } catch (const Error& error) {
    // A driver's build log keeps its lines.
    const bool is_log = error.kind() == ErrorKind::kKernel;
    return fail(static_cast<simuli_status>(error.exit_code()),
                is_log ? std::string(error.what()) : on_one_line(error.what()));
  } catch (const std::bad_alloc&) {
    return fail(SIMULI_MEMORY, "out of memory");
  } catch (const std::exception& error) {
    return fail(SIMULI_INTERNAL, on_one_line(error.what()));
  } catch (...) {
    return fail(SIMULI_INTERNAL, "an unknown exception");
  }
}

template <class T>
T& need(T* pointer, const char* argument) {
  if (pointer == nullptr) throw Error(ErrorKind::kUsage, fmt::format("{}: found NULL", argument));
  return *pointer;
}
void need_length(const char* argument, std::size_t found, std::size_t allowed);

[[nodiscard]] inline std::string text(const char* optional) { return optional == nullptr ? "" : optional; }
/// Throws Error{kUsage} for a zero quaternion or non-finite numbers.
[[nodiscard]] Pose pose_of(const simuli_pose& p);
[[nodiscard]] simuli_pose to_c(const Pose& p);
/// Throws Error{kUsage} for an end before the start or non-finite times.
[[nodiscard]] Shot shot_of(const simuli_shot& s);
[[nodiscard]] std::string quality_of(const simuli_options* options);
[[nodiscard]] std::vector<std::string> settings_of(const simuli_options* options);
/// Converts an edit for a single frame; throws Error{kUsage} for SIMULI_DUPLICATE.
[[nodiscard]] ActorEdit edit_of(const simuli_edit& edit);
/// Returns a sensor of the scene, including added sensors.
[[nodiscard]] Sensor sensor_of(const simuli_scene& scene, const char* name);

}  // namespace simuli::capi
