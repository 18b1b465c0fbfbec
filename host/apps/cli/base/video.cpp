#include "host/apps/cli/base/video.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fmt/format.h>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

bool has_program(std::string_view name) {
  const char* const variable = std::getenv("PATH");
  const std::string path = variable == nullptr ? "" : variable;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t end = std::min(path.find(':', at), path.size());
    if (::access((fs::path(path.substr(at, end - at)) / name).c_str(), X_OK) == 0) return true;
    at = end + 1;
  }
  return false;
}

/// Quotes for a POSIX shell.
std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + '\'';
}

}  // namespace

bool is_video(const fs::path& file) {
  constexpr std::array kExtensions{".mp4", ".mkv", ".webm", ".mov", ".gif"};
  return std::find(kExtensions.begin(), kExtensions.end(), ending_of(file)) != kExtensions.end();
}

Video::Video(fs::path file, double frames_per_s) : file_(std::move(file)), frames_per_s_(frames_per_s) {
  if (!has_program("ffmpeg")) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("{}: found no program ffmpeg for videos, allowed a folder of pictures", file_.string()));
  }
  temporary_.emplace(file_);
}

Video::~Video() {
  if (pipe_ != nullptr) pclose(pipe_);
}

void Video::fail() {
  if (pipe_ != nullptr) pclose(std::exchange(pipe_, nullptr));
  throw Error(ErrorKind::kInput, fmt::format("{}: ffmpeg could not write it", file_.string()));
}

void Video::add(const Image& image) {
  if (pipe_ == nullptr) {
    std::signal(SIGPIPE, SIG_IGN);  // a failing ffmpeg is an error, not the end of the program
    width_ = image.width;
    height_ = image.height;
    // Most encoders need even sizes. Without a tag, players choose BT.601 or BT.709 by the size of the video.
    const bool has_matrix = ending_of(file_) != ".gif";
    const std::string colours =
        has_matrix ? ",scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,setparams=range=tv:"
                     "colorspace=bt709:color_primaries=bt709:color_trc=bt709' -color_range tv "
                     "-colorspace bt709 -color_primaries bt709 -color_trc bt709"
                   : "'";
    const std::string command = fmt::format(
        "ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {}x{} -r {:.6f} -i - "
        "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2{} -pix_fmt yuv420p {}",
        width_,
        height_,
        frames_per_s_,
        colours,
        in_quotes(temporary_->path().string()));
    pipe_ = popen(command.c_str(), "w");
    if (pipe_ == nullptr) fail();
  }
  if (image.width != width_ || image.height != height_ || image.channels != 3) {
    throw Error(ErrorKind::kInternal, "video: pictures of different sizes");
  }
  std::vector<unsigned char> bytes(image.data.size());
  std::transform(image.data.begin(), image.data.end(), bytes.begin(), [](float v) {
    return static_cast<unsigned char>(std::lround(255.0F * std::clamp(v, 0.0F, 1.0F)));
  });
  if (std::fwrite(bytes.data(), 1, bytes.size(), pipe_) != bytes.size()) fail();
}

void Video::finish() {
  if (pipe_ == nullptr) return;
  const int status = pclose(std::exchange(pipe_, nullptr));
  if (status < 0) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: found no exit code of ffmpeg ({}), allowed exit code 0",
                            file_.string(),
                            std::generic_category().message(errno)));
  }
  if (status != 0) fail();
  temporary_->become_target();
}

}  // namespace simuli::cli
