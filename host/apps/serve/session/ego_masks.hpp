#pragma once
// Pictures of one's own vehicle, as its cameras see it, over what is rendered.
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
  std::string camera;  // its name
  auto operator<=>(const EgoMaskId&) const = default;
};

/// A folder of them: RIG/CAMERA.png, with alpha. Safe to use from any thread.
class EgoMasks {
 public:
  /// None at all.
  EgoMasks() = default;
  /// Reads them. Error{kInput} for a folder or a picture that can't be read.
  explicit EgoMasks(const std::filesystem::path& folder);

  [[nodiscard]] std::vector<EgoMaskId> ids() const;
  /// Refusal{kNotFound} naming those there are.
  void need(const EgoMaskId& id) const;
  /// Lays one over a picture of three channels and any size, to which it is scaled.
  void lay_over(Image& picture, const EgoMaskId& id) const;

 private:
  std::map<EgoMaskId, Image> ego_masks_;  // colours times alpha, alpha
};

}  // namespace simuli::serve
