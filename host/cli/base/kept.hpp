#pragma once
// What commands share that run one after the other in one process (host/cli/batch). A command on its own
// keeps nothing.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "host/cli/base/commands.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// The scene that was read last, and the device and the scene on it that were used last.
class Kept {
 public:
  /// As read_scene(), but read once as long as its files are the same.
  [[nodiscard]] SceneFile scene(const std::filesystem::path& path);
  /// The scene on the device, valid until the next call. `is_as_read`: it is what scene() gave last, without
  /// edits, and stays there for the next one. Errors as Device::best() and SceneOnDevice.
  [[nodiscard]] SceneOnDevice& on_device(const std::string& device,
                                         Scene scene,
                                         const RenderOptions& options,
                                         bool is_as_read);
  /// After an error nobody knows what is left of them.
  void drop();

 private:
  void drop_device();

  std::string read_;  // where from, and its fingerprint
  std::optional<SceneFile> scene_;
  std::string device_name_;
  std::optional<Device> device_;
  std::string on_device_read_;  // empty: of a scene that was edited
  std::optional<SceneOnDevice> on_device_;
};

/// The scene of a command that renders: kept where something is kept, else its own.
[[nodiscard]] SceneFile read_scene(const Globals& globals, const std::filesystem::path& path);
[[nodiscard]] SceneOnDevice& on_device(const Globals& globals,
                                       std::optional<SceneOnDevice>& own,
                                       Scene scene,
                                       const RenderOptions& options,
                                       bool is_as_read);

}  // namespace simuli::cli
