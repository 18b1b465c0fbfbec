#include "host/cli/base/kept.hpp"

#include <fmt/format.h>
#include <utility>

#include "io/base/fingerprint.hpp"

namespace simuli::cli {

SceneFile Kept::scene(const std::filesystem::path& path) {
  const std::string found = fmt::format("{}: {}", path.string(), fingerprint(path));
  if (!scene_ || found != read_) {
    scene_.reset();  // before there is another one
    scene_ = simuli::read_scene(path);
    read_ = found;
  }
  return *scene_;
}

SceneOnDevice& Kept::on_device(const std::string& device,
                               Scene scene,
                               const RenderOptions& options,
                               bool is_as_read) {
  if (!device_ || device != device_name_) {
    drop_device();
    device_ = Device::best(device);
    device_name_ = device;
  }
  const std::string read = is_as_read ? read_ : "";
  if (on_device_ && on_device_->options() == options) {
    if (read.empty() || read != on_device_read_) on_device_->set_scene(std::move(scene));
  } else {
    on_device_.reset();
    on_device_.emplace(*device_, std::move(scene), options);
  }
  on_device_read_ = read;
  return *on_device_;
}

void Kept::drop_device() {
  on_device_.reset();
  device_.reset();
}

void Kept::drop() {
  drop_device();
  scene_.reset();
}

SceneFile read_scene(const Globals& globals, const std::filesystem::path& path) {
  return globals.kept == nullptr ? simuli::read_scene(path) : globals.kept->scene(path);
}

SceneOnDevice& on_device(const Globals& globals,
                         std::optional<SceneOnDevice>& own,
                         Scene scene,
                         const RenderOptions& options,
                         bool is_as_read) {
  if (globals.kept != nullptr)
    return globals.kept->on_device(globals.device, std::move(scene), options, is_as_read);
  return own.emplace(Device::best(globals.device), std::move(scene), options);
}

}  // namespace simuli::cli
