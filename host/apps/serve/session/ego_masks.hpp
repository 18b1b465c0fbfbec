#pragma once
// Pictures of the ego vehicle as seen by its cameras, drawn over rendered pictures.
#include <compare>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "host/core/base/image.hpp"

namespace simuli::serve {

struct EgoMaskId {
  std::string rig;
  std::string camera;  // name of the camera
  auto operator<=>(const EgoMaskId&) const = default;
};

/// A folder of pictures with alpha: RIG/CAMERA.png. Safe to use from any thread.
class EgoMasks {
 public:
  /// Contains no masks.
  EgoMasks() = default;
  /// Reads the folder. Throws Error{kInput} for an unreadable folder or picture.
  explicit EgoMasks(const std::filesystem::path& folder);

  [[nodiscard]] std::vector<EgoMaskId> ids() const;
  /// Throws Refusal{kNotFound} with the available names for an unknown mask.
  void need(const EgoMaskId& id) const;
  /// Draws a mask over a picture with three channels of any size, to which the mask is scaled.
  void lay_over(Image& picture, const EgoMaskId& id) const;

 private:
  std::map<EgoMaskId, Image> ego_masks_;  // colours times alpha, and alpha
};

}  // namespace simuli::serve
