#include "io/picture/exr_header.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <string>
#include <system_error>

#include "host/base/error.hpp"

namespace simuli {
namespace {

static_assert(std::endian::native == std::endian::little, "the format is little endian");

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kDeepOrSeveralParts = 0x1800;  // flags of the version
constexpr std::size_t kLongestName = 255;
constexpr std::int64_t kLargestSide_px = 65536;
constexpr std::uint32_t kLargestTile_px = 1024;

class Header {
 public:
  explicit Header(const std::filesystem::path& file) : file_(file.string()), in_(file, std::ios::binary) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (error || !in_) refuse("file", "one that can't be read", "a readable OpenEXR file");
    left_ = bytes;
  }

  void check() {
    if (next<std::uint32_t>() != kMagic) refuse("first bytes", "others", "those of OpenEXR");
    if ((next<std::uint32_t>() & kDeepOrSeveralParts) != 0) {
      refuse("parts", "several, or deep ones", "one flat picture");
    }
    for (std::string name = text(); !name.empty(); name = text()) {
      (void)text();  // its type
      const auto bytes = next<std::uint32_t>();
      if (bytes > left_) {
        refuse("header", fmt::format("an attribute of {} bytes in {}", bytes, left_), "a whole OpenEXR file");
      }
      if (name == "dataWindow" || name == "displayWindow") {
        check_window(name, bytes);
      } else if (name == "tiles") {
        check_tiles(bytes);
      } else {
        skip(bytes);
      }
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& field, const std::string& found, const char* allowed) const {
    throw_input_error(file_, field, found, allowed);
  }

  void read(char* to, std::size_t bytes) {
    if (bytes > left_ || !in_.read(to, static_cast<std::streamsize>(bytes))) {
      refuse("header", "cut short", "a whole OpenEXR file");
    }
    left_ -= bytes;
  }

  void skip(std::size_t bytes) {
    in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
    left_ -= bytes;
  }

  template <class T>
  T next() {
    T value{};
    read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }

  std::string text() {
    std::string out;
    for (char c = next<char>(); c != '\0'; c = next<char>()) {
      out += c;
      if (out.size() > kLongestName) refuse("header", "a name without an end", "a whole OpenEXR file");
    }
    return out;
  }

  void check_window(const std::string& name, std::uint32_t bytes) {
    std::array<std::int32_t, 4> box{};  // the first and last x, y: both within
    if (bytes != sizeof box) refuse(name, fmt::format("{} bytes", bytes), "four numbers");
    for (std::int32_t& side : box) side = next<std::int32_t>();
    for (const std::size_t axis : {0U, 1U}) {
      const std::int64_t side = std::int64_t{box[axis + 2]} - box[axis] + 1;
      if (side >= 1 && side <= kLargestSide_px) continue;
      refuse(name, fmt::format("{} pixels a side", side), "1 to 65536");
    }
  }

  void check_tiles(std::uint32_t bytes) {
    constexpr std::uint32_t kBytes = 9;
    if (bytes != kBytes) refuse("tiles", fmt::format("{} bytes", bytes), "9");
    for (int axis = 0; axis < 2; ++axis) {
      const auto side = next<std::uint32_t>();
      if (side < 1 || side > kLargestTile_px)
        refuse("tiles", fmt::format("{} pixels a side", side), "1 to 1024");
    }
    (void)next<char>();  // how levels are made
  }

  std::string file_;
  std::ifstream in_;
  std::uintmax_t left_ = 0;
};

}  // namespace

void require_sound_exr_header(const std::filesystem::path& file) { Header(file).check(); }

}  // namespace simuli
