#pragma once
// What reads and writes the bytes of pictures: OpenImageIO, with the two hundred libraries that distributions
// build it with. A shared object of its own (libsimuli_pictures) holds what uses it and is loaded with the
// first picture, so that programs that need none start without them; -DSIMULI_LOAD_PICTURES=OFF links it as
// all else.
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
  std::vector<std::string> channel_names{};  // written: the format's own where there are none
};

enum class SampleType { kUint8, kUint16, kFloat };

/// A picture to write: `samples` is [height][width][channels] of `type`, `attributes` are the format's.
struct PictureSamples {
  PictureLayout layout{};
  SampleType type = SampleType::kUint8;
  const void* samples = nullptr;
  std::vector<std::pair<std::string, std::string>> attributes{};
};

/// Attributes of OpenEXR files here: without loss, and of no date, else the same picture has other bits each
/// second.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> reproducible_exr();

/// Why something failed, as the library says it (of several lines, or empty); none where it did not.
using PictureFailure = std::optional<std::string>;

class PictureInput {
 public:
  PictureInput() = default;
  PictureInput(const PictureInput&) = delete;
  PictureInput& operator=(const PictureInput&) = delete;
  virtual ~PictureInput() = default;
  [[nodiscard]] virtual PictureLayout layout() const = 0;
  /// Everything as float, [height][width][channels], and closes it. Decoders may hand over a part: that
  /// fails. Memory is taken as rows come: headers claim what they like.
  [[nodiscard]] virtual PictureFailure read(std::vector<float>& samples) = 0;
};

/// Throws nothing but std::bad_alloc: what is thrown in one shared object is not always caught in another.
class PictureCodec {
 public:
  PictureCodec() = default;
  PictureCodec(const PictureCodec&) = delete;
  PictureCodec& operator=(const PictureCodec&) = delete;
  virtual ~PictureCodec() = default;
  /// `format` by OpenImageIO's name. Colours as stored, not multiplied by alpha. Null with `failure` set.
  [[nodiscard]] virtual std::unique_ptr<PictureInput> open(const std::string& format,
                                                           const std::filesystem::path& file,
                                                           std::string& failure) const = 0;
  /// The format by the file's extension.
  [[nodiscard]] virtual PictureFailure write(const std::filesystem::path& file,
                                             const PictureSamples& picture) const = 0;
  /// The bytes of the file that write() would make of that name.
  [[nodiscard]] virtual PictureFailure encode(const std::string& name,
                                              const PictureSamples& picture,
                                              std::string& bytes) const = 0;
};

/// The one codec, loaded by the first call. Error{kInternal} naming what is missing where it can't be; the
/// next call tries again.
[[nodiscard]] const PictureCodec& picture_codec();

}  // namespace simuli

/// What the shared object shows; another number when anything above changes, so that one of another build is
/// refused.
extern "C" const simuli::PictureCodec* simuli_picture_codec_2();
