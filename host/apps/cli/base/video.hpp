#pragma once
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "host/core/base/image.hpp"
#include "io/base/temporary.hpp"

namespace simuli::cli {

/// Whether the extension is one of a video: .mp4, .mkv, .webm, .mov or .gif.
[[nodiscard]] bool is_video(const std::filesystem::path& file);

/// Writes pictures to a video with the program ffmpeg from PATH.
class Video {
 public:
  /// Throws Error{kUsage} when ffmpeg is missing. `frames_per_s` must be above 0.
  Video(std::filesystem::path file, double frames_per_s);
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;
  ~Video();

  /// Adds a picture of the first picture's size with 3 channels. Throws Error{kInput} when ffmpeg fails.
  void add(const Image& image);
  /// Waits for ffmpeg. Throws Error{kInput} when ffmpeg failed; then no file remains.
  void finish();

 private:
  [[noreturn]] void fail();

  std::filesystem::path file_;
  std::optional<Temporary> temporary_;  // until the file is complete
  double frames_per_s_;
  int width_ = 0, height_ = 0;
  std::FILE* pipe_ = nullptr;
};

}  // namespace simuli::cli
