#pragma once
// Pictures as bytes, made on the device: an eighth of what a frame's results take on their way to the host.
#include <memory>
#include <string>

#include "host/device/render/scene/frame.hpp"
#include "host/device/runtime/pending.hpp"

namespace simuli {

enum class PixelOrder {
  kInterleaved,  // [height][width][3]
  kPlanar        // [3][height][width]
};

/// Makes them on one device. Used by the thread that uses the frames' scene.
class PictureBytes {
 public:
  explicit PictureBytes(const Device& device);
  PictureBytes(PictureBytes&&) noexcept;
  PictureBytes& operator=(PictureBytes&&) noexcept;
  ~PictureBytes();

  /// What image() of a camera's frame shows, each value the nearest of 255 steps, as write_image() rounds it;
  /// does not wait. Frames that are rendered later leave them as they are. Error{kUsage} of a LiDAR.
  [[nodiscard]] ByteDownload start(const Frame& frame, PixelOrder order);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
