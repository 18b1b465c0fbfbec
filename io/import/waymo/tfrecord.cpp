#include "io/import/waymo/tfrecord.hpp"

#include <array>
#include <cstring>
#include <fmt/format.h>
#include <system_error>

#include "host/base/error.hpp"
#include "io/base/regular_file.hpp"

namespace simuli {

TfRecords::TfRecords(const std::filesystem::path& file) : file_(file.string()) {
  need_regular_file(file);
  in_.open(file, std::ios::binary);
  std::error_code error;
  bytes_ = std::filesystem::is_regular_file(file, error) ? std::filesystem::file_size(file, error) : 0;
  if (error || !in_ || bytes_ == 0) throw_input_error(file_, "file", "nothing to read", "a .tfrecord");
}

bool TfRecords::next(std::string& record) {
  if (at_ == bytes_) return false;
  constexpr std::uintmax_t kFrame = 16;
  std::array<char, 12> head{};
  std::uint64_t length = 0;
  const bool has_head = bytes_ - at_ >= kFrame && in_.read(head.data(), head.size()).good();
  std::memcpy(&length, head.data(), 8);
  if (!has_head || length > bytes_ - at_ - kFrame) {
    throw_input_error(file_, "record", fmt::format("{} bytes to go", bytes_ - at_), "a whole record");
  }
  record.resize(length);
  in_.read(record.data(), static_cast<std::streamsize>(length));
  in_.ignore(4);
  at_ += kFrame + length;
  return true;
}

}  // namespace simuli
