#include <array>
#include <cstring>
#include <fmt/format.h>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/waymo/waymo_frame.hpp"

namespace simuli {

namespace {

constexpr const char* kAllowed =
    "a .tfrecord of frames (Waymo Open Dataset, Perception, version 1; "
    "examples/convert_waymo2.py makes one of version 2)";

}  // namespace

TfRecords::TfRecords(const std::filesystem::path& file) : file_(file.string()) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw_input_error(file_, "file", "a folder", kAllowed);
  need_regular_file(file);
  in_.open(file, std::ios::binary);
  bytes_ = std::filesystem::is_regular_file(file, error) ? std::filesystem::file_size(file, error) : 0;
  if (!is_there(file)) throw_input_error(file_, "file", "no such file", kAllowed);
  if (error || !in_ || bytes_ == 0) throw_input_error(file_, "file", "nothing to read", kAllowed);
}

bool TfRecords::next(std::string& record) {
  if (at_ == bytes_) return false;
  constexpr std::uintmax_t kFrame = 16;
  std::array<char, 12> head{};
  std::uint64_t length = 0;
  const bool has_head = bytes_ - at_ >= kFrame && in_.read(head.data(), head.size()).good();
  std::memcpy(&length, head.data(), 8);
  const bool is_whole = has_head && length <= bytes_ - at_ - kFrame;
  if (!is_whole && at_ == 0) {
    throw_input_error(
        file_, "file", fmt::format("{} bytes that begin with no whole record", bytes_), kAllowed);
  }
  if (!is_whole) {
    throw_input_error(file_, "record", fmt::format("{} bytes to go", bytes_ - at_), "a whole record");
  }
  record.resize(length);
  in_.read(record.data(), static_cast<std::streamsize>(length));
  in_.ignore(4);
  at_ += kFrame + length;
  return true;
}

}  // namespace simuli
