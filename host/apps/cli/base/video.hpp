#pragma once
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "host/core/base/image.hpp"
#include "io/base/temporary.hpp"

namespace simuli::cli {

/// Whether a file of this name is a video: .mp4, .mkv, .webm, .mov or .gif.
[[nodiscard]] bool is_video(const std::filesystem::path& file);

/// Pictures to a video through the program ffmpeg, which is looked for in PATH.
class Video {
 public:
  /// Error{kUsage} when there is no ffmpeg. `frames_per_s` above 0.
  Video(std::filesystem::path file, double frames_per_s);
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;
  ~Video();

  /// All pictures have the size of the first, 3 channels. Error{kInput} when ffmpeg refuses.
  void add(const Image& image);
  /// Waits for ffmpeg. Error{kInput} when it failed; then no file is left.
  void finish();

 private:
  [[noreturn]] void fail();

  std::filesystem::path file_;
  std::optional<Temporary> temporary_;  // until it is whole
  double frames_per_s_;
  int width_ = 0, height_ = 0;
  std::FILE* pipe_ = nullptr;
};

}  // namespace simuli::cli
