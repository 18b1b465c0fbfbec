#pragma once
// Converts pictures to bytes on the device, an eighth of the data of a frame's results.
#include <memory>
#include <string>

#include "host/device/render/scene/frame.hpp"
#include "host/device/runtime/pending.hpp"

namespace simuli {

enum class PixelOrder {
  kInterleaved,  // [height][width][3]
  kPlanar        // [3][height][width]
};

/// Converts pictures on one device. Used by the thread that uses the frames' scene.
class PictureBytes {
 public:
  explicit PictureBytes(const Device& device);
  PictureBytes(PictureBytes&&) noexcept;
  PictureBytes& operator=(PictureBytes&&) noexcept;
  ~PictureBytes();

  /// Queues image() of a camera's frame in 255 steps, rounded like write_image(); does not wait. Later frames
  /// do not change it. Throws Error{kUsage} for a LiDAR.
  [[nodiscard]] ByteDownload start(const Frame& frame, PixelOrder order);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
