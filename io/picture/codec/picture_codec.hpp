#pragma once
// Interface to OpenImageIO, which distributions build with about two hundred libraries. A separate shared
// object (libsimuli_pictures) contains the implementation and is loaded with the first picture, so that
// programs without pictures start faster; -DSIMULI_LOAD_PICTURES=OFF links it directly.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace simuli {

struct PictureLayout {
  int width = 0;
  int height = 0;
  int depth = 1;
  int channels = 0;
  std::vector<std::string> channel_names{};  // for writing; empty: the format's default
};

enum class SampleType { kUint8, kUint16, kFloat };

/// A picture to write: `samples` is [height][width][channels] of `type`; `attributes` are the format's.
struct PictureSamples {
  PictureLayout layout{};
  SampleType type = SampleType::kUint8;
  const void* samples = nullptr;
  std::vector<std::pair<std::string, std::string>> attributes{};
};

/// Returns attributes for reproducible OpenEXR files: lossless compression, and no date.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> reproducible_exr();

/// Error message of the library, possibly of several lines or empty; no value on success.
using PictureFailure = std::optional<std::string>;

class PictureInput {
 public:
  PictureInput() = default;
  PictureInput(const PictureInput&) = delete;
  PictureInput& operator=(const PictureInput&) = delete;
  virtual ~PictureInput() = default;
  [[nodiscard]] virtual PictureLayout layout() const = 0;
  /// Reads all samples as float, [height][width][channels], and closes the file. Fails for partially decoded
  /// pictures. Allocates memory while rows are decoded, because headers may claim any size.
  [[nodiscard]] virtual PictureFailure read(std::vector<float>& samples) = 0;
};

/// Throws only std::bad_alloc, because exceptions do not always cross shared objects.
class PictureCodec {
 public:
  PictureCodec() = default;
  PictureCodec(const PictureCodec&) = delete;
  PictureCodec& operator=(const PictureCodec&) = delete;
  virtual ~PictureCodec() = default;
  /// Opens a file in `format` (OpenImageIO's name). Colours as stored, not multiplied by alpha. Returns null
  /// and sets `failure` on errors.
  [[nodiscard]] virtual std::unique_ptr<PictureInput> open(const std::string& format,
                                                           const std::filesystem::path& file,
                                                           std::string& failure) const = 0;
  /// Writes a picture; the extension selects the format.
  [[nodiscard]] virtual PictureFailure write(const std::filesystem::path& file,
                                             const PictureSamples& picture) const = 0;
  /// Returns the bytes that write() would write for this name.
  [[nodiscard]] virtual PictureFailure encode(const std::string& name,
                                              const PictureSamples& picture,
                                              std::string& bytes) const = 0;
};

/// Returns the codec, loaded by the first call. Throws Error{kInternal} naming the missing file if it cannot be
/// loaded; the next call tries again.
[[nodiscard]] const PictureCodec& picture_codec();

}  // namespace simuli

/// Entry point of the shared object; the number changes with the interface above, so that an object of another
/// build is refused.
extern "C" const simuli::PictureCodec* simuli_picture_codec_2();
