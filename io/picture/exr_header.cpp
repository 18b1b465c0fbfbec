#include "io/picture/exr_header.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"

namespace simuli {
namespace {

static_assert(std::endian::native == std::endian::little, "the format is little endian");

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kDeepOrSeveralParts = 0x1800;  // flags in the version field
constexpr std::size_t kLongestHeaderName = 254;
constexpr std::uint32_t kLargestTile_px = 1024;

/// Types that OpenEXR reads without checking the attribute's size; a wrong size would misplace the next
/// attribute's length.
struct Sized {
  std::string_view type;
  std::uint32_t bytes;
};
constexpr std::array<Sized, 24> kSized{{{"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
                                        {"compression", 1}, {"double", 8},   {"envmap", 1},
                                        {"float", 4},       {"int", 4},      {"keycode", 28},
                                        {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
                                        {"m44f", 64},       {"m44d", 128},   {"rational", 8},
                                        {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
                                        {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
                                        {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}}};

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
      const std::string type = text();
      const auto bytes = next<std::uint32_t>();
      if (bytes > left_) {
        refuse("header", fmt::format("an attribute of {} bytes in {}", bytes, left_), "a whole OpenEXR file");
      }
      for (const Sized& sized : kSized) {
        if (type == sized.type && bytes != sized.bytes) {
          refuse(type + " attribute", fmt::format("{} bytes", bytes), fmt::format("{}", sized.bytes));
        }
      }
      if (type == "preview" || type == "idmanifest") refuse("attribute", type, "a picture without");
      if (type == "chlist") {
        check_channels(bytes);
      } else if (name == "dataWindow" || name == "displayWindow") {
        check_window(name, bytes);
      } else if (name == "tiles") {
        check_tiles(bytes);
      } else {
        skip(bytes);
      }
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
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
      if (out.size() > kLongestHeaderName) refuse("header", "a name without an end", "a whole OpenEXR file");
    }
    return out;
  }

  /// Checks the channel list: names followed by 16 bytes, up to an empty name, in exactly `bytes` bytes.
  void check_channels(std::uint32_t bytes) {
    constexpr std::size_t kOfOne = 16;
    const std::uintmax_t end = left_ - bytes;
    while (!text().empty()) {
      if (left_ < kOfOne) refuse("header", "cut short", "a whole OpenEXR file");
      skip(kOfOne);
    }
    if (left_ != end) refuse("channels", "a list with a wrong length", "a whole OpenEXR file");
  }

  void check_window(const std::string& name, std::uint32_t bytes) {
    std::array<std::int32_t, 4> box{};  // inclusive minimum and maximum x, y
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
    (void)next<char>();  // level mode
  }

  std::string file_;
  std::ifstream in_;
  std::uintmax_t left_ = 0;
};

}  // namespace

void require_sound_exr_header(const std::filesystem::path& file) { Header(file).check(); }

}  // namespace simuli
