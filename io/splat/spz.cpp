#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/bytes.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_axes.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/spz_bytes.hpp"

namespace simuli {
namespace {

// Layout of the format's published reference (Niantic, MIT). All numbers are little endian.
constexpr std::string_view kMagic = "NGSP";
constexpr std::size_t kHeaderBytes = 16;  // of versions 1 to 3
constexpr std::size_t kHeaderBytesV4 =
    32;  // followed by a table of contents and a Zstandard frame per stream
constexpr std::size_t kMaxBytes = std::size_t{8} << 30U;
constexpr double kColorScale = 0.15;
constexpr float kSqrtHalf = 0.70710678F;
constexpr float kLargestMagnitude = 511.0F;  // of a 9-bit component

struct Header {
  std::uint32_t version = 0;
  std::uint32_t points = 0;
  int sh_degree = 0;
  int fractional_bits = 0;
  bool is_antialiased = false;
};

/// The streams in file order, each with all points.
struct Streams {
  std::array<const std::uint8_t*, 6> at{};  // positions, alphas, colours, scales, rotations, SH
};
enum Stream : std::size_t { kPositions, kAlphas, kColors, kScales, kRotations, kSh };

std::array<std::size_t, 6> stream_bytes(const Header& h) {
  const std::size_t higher = static_cast<std::size_t>((h.sh_degree + 1) * (h.sh_degree + 1) - 1);
  const std::size_t n = h.points;
  return {n * (h.version == 1 ? 6 : 9), n, 3 * n, 3 * n, n * (h.version >= 3 ? 4 : 3), 3 * higher * n};
}

std::uint64_t little_endian(const std::string& bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = count; i-- > 0;) value = value << 8U | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

Header parse_header(const std::string& bytes, const std::string& file) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with(kMagic)) {
    throw_input_error(file, "magic", "other bytes", "NGSP, in gzip or not");
  }
  Header h;
  h.version = static_cast<std::uint32_t>(little_endian(bytes, 4, 4));
  h.points = static_cast<std::uint32_t>(little_endian(bytes, 8, 4));
  h.sh_degree = static_cast<std::uint8_t>(bytes[12]);
  h.fractional_bits = static_cast<std::uint8_t>(bytes[13]);
  h.is_antialiased = (static_cast<std::uint8_t>(bytes[14]) & 1U) != 0;
  if (h.version < 1 || h.version > 4) {
    throw_input_error(file, "version", fmt::format("{}", h.version), "1 to 4");
  }
  const int highest = h.version == 4 ? 4 : 3;
  if (h.sh_degree > highest) {
    throw_input_error(file, "SH degree", fmt::format("{}", h.sh_degree), fmt::format("0 to {}", highest));
  }
  if (h.fractional_bits > 23) {
    throw_input_error(file, "fractional bits", fmt::format("{}", h.fractional_bits), "0 to 23");
  }
  return h;
}

/// Decompresses the streams of version 4. The result has the layout of version 3.
std::string unpack_v4(const std::string& bytes, const Header& h, const std::string& file) {
  if (bytes.size() < kHeaderBytesV4) throw_input_error(file, "header", "cut short", "32 bytes");
  const std::size_t streams = static_cast<std::uint8_t>(bytes[15]);
  std::size_t toc = little_endian(bytes, 16, 4);
  const auto sizes = stream_bytes(h);
  const std::size_t needed = h.sh_degree > 0 ? 6 : 5;
  if (streams < needed || toc < kHeaderBytesV4 || toc > bytes.size() || (bytes.size() - toc) / 16 < streams) {
    throw_input_error(file, "table of contents", fmt::format("{} streams", streams), "all of them");
  }
  std::size_t at = toc + 16 * streams;
  std::string out = bytes.substr(0, kHeaderBytes);
  for (std::size_t i = 0; i < needed; ++i, toc += 16) {
    const std::uint64_t packed = little_endian(bytes, toc, 8);
    const std::uint64_t size = little_endian(bytes, toc + 8, 8);
    if (size != sizes[i] || packed > bytes.size() - at) {
      throw_input_error(file,
                        fmt::format("stream {}", i),
                        fmt::format("{} bytes in {}", size, packed),
                        fmt::format("{} bytes in at most {}", sizes[i], bytes.size() - at));
    }
    out += unzstd(bytes.data() + at, packed, size, file);
    at += packed;
  }
  return out;
}

float half_to_float(std::uint32_t half) {
  const float sign = (half & 0x8000U) != 0 ? -1.0F : 1.0F;
  const int exponent = static_cast<int>(half >> 10U & 31U);
  const auto mantissa = static_cast<float>(half & 1023U);
  if (exponent == 31) return std::numeric_limits<float>::quiet_NaN();
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024.0F + mantissa, exponent - 25));
}

float position(const std::uint8_t* stream, std::size_t index, const Header& h) {
  if (h.version == 1) {
    const std::uint8_t* p = stream + 2 * index;
    return half_to_float(static_cast<std::uint32_t>(p[0]) | static_cast<std::uint32_t>(p[1]) << 8U);
  }
  const std::uint8_t* p = stream + 3 * index;
  const std::uint32_t high = static_cast<std::uint32_t>(p[0]) << 8U |
                             static_cast<std::uint32_t>(p[1]) << 16U |
                             static_cast<std::uint32_t>(p[2]) << 24U;
  return std::ldexp(static_cast<float>(std::bit_cast<std::int32_t>(high) / 256), -h.fractional_bits);
}

/// Returns w, x, y, z; the file's order is x, y, z, w.
std::array<float, 4> rotation(const std::uint8_t* stream, std::size_t point, std::uint32_t version) {
  std::array<float, 4> xyzw{};
  float rest = 1.0F;
  if (version < 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      xyzw[i] = static_cast<float>(stream[3 * point + i]) / 127.5F - 1.0F;
      rest -= xyzw[i] * xyzw[i];
    }
    xyzw[3] = std::sqrt(std::max(rest, 0.0F));
  } else {
    std::uint32_t bits = 0;
    for (std::size_t i = 4; i-- > 0;) bits = bits << 8U | stream[4 * point + i];
    const std::size_t largest = bits >> 30U;
    for (std::size_t i = 4; i-- > 0;) {
      if (i == largest) continue;
      const float magnitude = kSqrtHalf * static_cast<float>(bits & 511U) / kLargestMagnitude;
      xyzw[i] = (bits & 512U) != 0 ? -magnitude : magnitude;
      rest -= xyzw[i] * xyzw[i];
      bits >>= 10U;
    }
    xyzw[largest] = std::sqrt(std::max(rest, 0.0F));
  }
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

/// Rotates by 180 degrees about x between the axes of SPZ and PLY: changes the signs of y and z, of rotations
/// about them, and of SH coefficients that are odd in one of the two.
void turn(GaussianSet& set) {
  constexpr std::array<int, 8> kOdd{1, 2, 4, 7, 9, 11, 12, 14};  // y, z, xy, xz, y(..), y(..), z(..), z(..)
  for (const int i : {1, 2}) {
    set.params.col(kMeanRow + i) *= -1.0F;
    set.params.col(kRotationRow + 1 + i) *= -1.0F;
  }
  for (const int k : kOdd) {
    if (k < sh_coefficients(set.sh_degree)) set.sh(k) *= -1.0F;
  }
}

float opacity_logit(std::uint8_t alpha) {
  // 0 and 255 become values half a step from the ends.
  const float share = std::clamp(static_cast<float>(alpha) / 255.0F, 0.5F / 255.0F, 254.5F / 255.0F);
  return std::log(share / (1.0F - share));
}

GaussianSet decode(const Header& h, const Streams& s) {
  const int degree = std::min(h.sh_degree, 3);
  const auto higher = static_cast<std::size_t>((h.sh_degree + 1) * (h.sh_degree + 1) - 1);
  GaussianSet set(SetKind::kCamera, degree, static_cast<Eigen::Index>(h.points));
  for (std::size_t v = 0; v < h.points; ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto c = static_cast<int>(i);
      set.params(row, kMeanRow + c) = position(s.at[kPositions], 3 * v + i, h);
      set.params(row, kLogScaleRow + c) = static_cast<float>(s.at[kScales][3 * v + i]) / 16.0F - 10.0F;
      set.params(row, kShRow + c) =
          (static_cast<float>(s.at[kColors][3 * v + i]) / 255.0F - 0.5F) / static_cast<float>(kColorScale);
    }
    const auto q = rotation(s.at[kRotations], v, h.version);
    for (std::size_t i = 0; i < 4; ++i) set.params(row, kRotationRow + static_cast<int>(i)) = q[i];
    set.params(row, kOpacityRow) = opacity_logit(s.at[kAlphas][v]);
    for (std::size_t k = 0; k < 3 * static_cast<std::size_t>(sh_coefficients(degree) - 1); ++k) {
      set.params(row, kShRow + 3 + static_cast<int>(k)) =
          (static_cast<float>(s.at[kSh][3 * higher * v + k]) - 128.0F) / 128.0F;
    }
  }
  return set;
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

std::uint32_t pack_rotation(const Eigen::Vector4f& wxyz) {
  const Eigen::Vector4f unit = wxyz.stableNormalized();
  const std::array<float, 4> q{unit[1], unit[2], unit[3], unit[0]};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(q[i]) > std::abs(q[largest])) largest = i;
  }
  auto bits = static_cast<std::uint32_t>(largest);
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    // the largest component is positive in the file
    const bool negative = (q[i] < 0.0F) != (q[largest] < 0.0F);
    const long magnitude = std::lround(kLargestMagnitude * std::min(std::abs(q[i]) / kSqrtHalf, 1.0F));
    bits = bits << 10U | (negative ? 512U : 0U) | static_cast<std::uint32_t>(magnitude);
  }
  return bits;
}

/// Returns the number of fractional bits, at most the usual 12, that leaves room for the farthest mean.
int fractional_bits_of(const GaussianSet& set, const std::string& file) {
  const float farthest = set.size() > 0 ? set.mean().cwiseAbs().maxCoeff() : 0.0F;
  constexpr int kUsual = 12, kFewest = 4;
  for (int bits = kUsual; bits >= kFewest; --bits) {
    if (std::ldexp(farthest, bits) < 8388607.0F) return bits;
  }
  throw_input_error(file, "means", fmt::format("{:.0f} m", farthest), "at most half a million metres");
}

}  // namespace

GaussianSet read_spz(const std::filesystem::path& file) {
  return read_spz(read_file(file, kMaxBytes), file.string());
}

GaussianSet read_spz(std::string bytes, const std::string& file, SplatReport* report) {
  GaussianSet set = set_of_spz(std::move(bytes), file, report);
  turn(set);
  return set;
}

GaussianSet set_of_spz(std::string bytes, const std::string& file, SplatReport* report) {
  const bool is_packed = is_gzip(bytes);
  const Header header = parse_header(is_packed ? gunzip_start(bytes, kHeaderBytes, file) : bytes, file);
  if (report != nullptr && header.is_antialiased) report->is_antialiased = true;
  const auto sizes = stream_bytes(header);
  const auto need_room = [&](std::size_t size, std::size_t room) {
    if (size <= room) return;
    throw_input_error(file,
                      "points",
                      fmt::format("{}", header.points),
                      fmt::format("as many as {} bytes hold", bytes.size()));
  };
  // A million splats that differ in one coordinate compress 44 to 1; larger claims would only allocate memory.
  constexpr std::size_t kMostOfByte = 128, kBeside = std::size_t{1} << 20U;
  const std::size_t held = std::accumulate(sizes.begin(), sizes.end(), kBeside);
  need_room(held, std::min(kMostOfByte * bytes.size() + kBeside, kMaxBytes));
  if (is_packed) bytes = gunzip(bytes, file, held);
  if (header.version == 4) bytes = unpack_v4(bytes, header, file);
  Streams streams;
  std::size_t at = kHeaderBytes;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    need_room(sizes[i], bytes.size() - at);
    streams.at[i] = reinterpret_cast<const std::uint8_t*>(bytes.data() + at);
    at += sizes[i];
  }
  return decode(header, streams);
}

void write_spz(const std::filesystem::path& file, const GaussianSet& set) {
  GaussianSet in_axes = set;
  turn(in_axes);
  write_file_atomically(file, spz_of(in_axes, file.string()));
}

std::string spz_of(const GaussianSet& set, const std::string& file) {
  need_camera_set(set, file);
  const int bits = fractional_bits_of(set, file);
  const Eigen::Index count = set.size();
  std::string out(kMagic);
  append_little_endian(out, 3, 4);
  append_little_endian(out, static_cast<std::uint32_t>(count), 4);
  append_little_endian(out, static_cast<std::uint32_t>(set.sh_degree), 1);
  append_little_endian(out, static_cast<std::uint32_t>(bits), 1);
  append_little_endian(out, 0, 2);
  for (Eigen::Index v = 0; v < count; ++v) {
    for (int i = 0; i < 3; ++i) {
      const long fixed = std::lround(std::ldexp(set.params(v, kMeanRow + i), bits));
      append_little_endian(out, static_cast<std::uint32_t>(fixed), 3);
    }
  }
  const auto append_bytes = [&](int first, int columns, auto&& encode) {
    for (Eigen::Index v = 0; v < count; ++v) {
      for (int c = 0; c < columns; ++c) out.push_back(static_cast<char>(encode(set.params(v, first + c))));
    }
  };
  append_bytes(kOpacityRow, 1, [](float x) { return to_byte(255.0F / (1.0F + std::exp(-x))); });
  append_bytes(kShRow, 3, [](float x) {
    return to_byte((std::clamp(x, -10.0F, 10.0F) * static_cast<float>(kColorScale) + 0.5F) * 255.0F);
  });
  append_bytes(
      kLogScaleRow, 3, [](float x) { return to_byte((std::clamp(x, -20.0F, 20.0F) + 10.0F) * 16.0F); });
  for (Eigen::Index v = 0; v < count; ++v) {
    append_little_endian(out, pack_rotation(set.rotation().row(v).transpose()), 4);
  }
  append_bytes(kShRow + 3, 3 * (sh_coefficients(set.sh_degree) - 1), [](float x) {
    return to_byte(std::clamp(x, -2.0F, 2.0F) * 128.0F + 128.0F);
  });
  return gzip(out);
}

}  // namespace simuli
