#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <string_view>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/ply_header.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

constexpr std::size_t kChunk = 256;  // particles per chunk, which share bounds
constexpr std::size_t kMaxCompressedHeaderBytes = std::size_t{1} << 16U;
constexpr std::array<std::string_view, 12> kBounds{"min_x",
                                                   "min_y",
                                                   "min_z",
                                                   "max_x",
                                                   "max_y",
                                                   "max_z",
                                                   "min_scale_x",
                                                   "min_scale_y",
                                                   "min_scale_z",
                                                   "max_scale_x",
                                                   "max_scale_y",
                                                   "max_scale_z"};
constexpr std::array<std::string_view, 6> kColorBounds{"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"};
constexpr std::array<std::string_view, 4> kPacked{
    "packed_position", "packed_rotation", "packed_scale", "packed_color"};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<std::string> properties;  // "float min_x"
};

/// Returns the elements of the header; `body` is the offset of the data.
std::vector<Element> parse_elements(const std::string& bytes, const std::string& file, std::size_t& body) {
  std::vector<Element> elements;
  const std::string_view head = std::string_view(bytes).substr(0, kMaxCompressedHeaderBytes);
  for (std::size_t at = 0, stop = 0; (stop = head.find('\n', at)) != std::string_view::npos; at = stop + 1) {
    std::string_view line = head.substr(at, stop - at);
    if (line.ends_with('\r')) line.remove_suffix(1);
    body = stop + 1;
    if (line == "end_header") return elements;
    if (line.starts_with("format ") && line != "format binary_little_endian 1.0") {
      throw_input_error(file, "format", "another one", "binary_little_endian 1.0");
    }
    if (line.starts_with("element ")) {
      const std::size_t blank = line.rfind(' ');
      Element e{std::string(line.substr(8, blank > 8 ? blank - 8 : 0)), 0, {}};
      const auto result = std::from_chars(line.data() + blank + 1, line.data() + line.size(), e.count);
      if (result.ec != std::errc{} || result.ptr != line.data() + line.size()) {
        throw_input_error(file, "element " + e.name, "no count", "a whole number");
      }
      elements.push_back(std::move(e));
    } else if (line.starts_with("property ") && !elements.empty()) {
      elements.back().properties.emplace_back(line.substr(9));
    }
  }
  throw_input_error(file, "header", "no end", "end_header");
}

template <std::size_t N>
bool holds(const Element& e,
           std::size_t first,
           const char* type,
           const std::array<std::string_view, N>& names) {
  if (e.properties.size() < first + N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    if (e.properties[first + i] != fmt::format("{} {}", type, names[i])) return false;
  }
  return true;
}

struct Contents {
  std::size_t chunk_floats = 0;  // 12 or 18
  std::size_t chunks = 0;
  std::size_t vertices = 0;
  int sh_degree = 0;
  const char* chunk_data = nullptr;
  const char* vertex_data = nullptr;
  const char* sh_data = nullptr;  // [vertices][3 (K - 1)], channel-major
};

int degree_of(std::size_t higher, const std::string& file) {
  for (int degree = 0; degree <= 3; ++degree) {
    if (higher == static_cast<std::size_t>(3 * (sh_coefficients(degree) - 1))) return degree;
  }
  throw_input_error(file, "element sh", fmt::format("{} properties", higher), "9, 24 or 45");
}

Contents parse(const std::string& bytes, const std::string& file) {
  std::size_t body = 0;
  const std::vector<Element> elements = parse_elements(bytes, file, body);
  Contents c;
  const bool named = elements.size() >= 2 && elements.size() <= 3 && elements[0].name == "chunk" &&
                     elements[1].name == "vertex" && (elements.size() == 2 || elements[2].name == "sh");
  if (!named || !holds(elements[0], 0, "float", kBounds) || !holds(elements[1], 0, "uint", kPacked) ||
      elements[1].properties.size() != kPacked.size()) {
    throw_input_error(
        file, "elements", "others", "chunk with bounds, vertex with packed_position to packed_color, sh");
  }
  c.chunk_floats = elements[0].properties.size();
  const bool colors = c.chunk_floats == kBounds.size() + kColorBounds.size() &&
                      holds(elements[0], kBounds.size(), "float", kColorBounds);
  if (c.chunk_floats != kBounds.size() && !colors) {
    throw_input_error(
        file, "element chunk", fmt::format("{} properties", c.chunk_floats), "12 bounds, or 18 with colours");
  }
  const std::size_t left = bytes.size() - body;
  const std::uint64_t vertices = elements[1].count, chunks = elements[0].count;
  if (vertices > left / 16 || chunks != (vertices + kChunk - 1) / kChunk) {
    throw_input_error(file,
                      "element vertex",
                      fmt::format("{} in {} chunks and {} bytes", vertices, chunks, left),
                      "16 bytes each, and a chunk for every 256");
  }
  c.vertices = vertices;
  c.chunks = chunks;
  std::size_t needed = 4 * c.chunk_floats * c.chunks + 16 * c.vertices;
  if (elements.size() == 3) {
    const Element& sh = elements[2];
    c.sh_degree = degree_of(sh.properties.size(), file);
    for (std::size_t i = 0; i < sh.properties.size(); ++i) {
      if (sh.properties[i] != fmt::format("uchar f_rest_{}", i)) {
        throw_input_error(file, "element sh", sh.properties[i], fmt::format("uchar f_rest_{}", i));
      }
    }
    if (sh.count != vertices) {
      throw_input_error(file, "element sh", fmt::format("{}", sh.count), fmt::format("{}", vertices));
    }
    needed += sh.properties.size() * c.vertices;
  }
  if (needed > left || !is_blank(std::string_view(bytes).substr(body + needed))) {
    throw_input_error(file, "data", fmt::format("{} bytes", left), fmt::format("{}", needed));
  }
  c.chunk_data = bytes.data() + body;
  c.vertex_data = c.chunk_data + 4 * c.chunk_floats * c.chunks;
  c.sh_data = c.vertex_data + 16 * c.vertices;
  return c;
}

std::uint32_t word_at(const char* data, std::size_t index) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8U | static_cast<std::uint8_t>(data[4 * index + i]);
  return word;
}
float float_at(const char* data, std::size_t index) { return std::bit_cast<float>(word_at(data, index)); }

float share(std::uint32_t word, unsigned shift, unsigned bits) {
  const std::uint32_t most = (1U << bits) - 1U;
  return static_cast<float>(word >> shift & most) / static_cast<float>(most);
}

/// Unpacks three numbers of 11, 10 and 11 bits between the chunk's bounds at `first` and three values later.
std::array<float, 3> unpack(std::uint32_t word, const char* chunk, std::size_t first) {
  const std::array<float, 3> t{share(word, 21, 11), share(word, 11, 10), share(word, 0, 11)};
  std::array<float, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const float low = float_at(chunk, first + i), high = float_at(chunk, first + 3 + i);
    out[i] = low * (1.0F - t[i]) + high * t[i];
  }
  return out;
}

/// Returns w, x, y, z; the largest component is omitted in the file and positive.
std::array<float, 4> unpack_rotation(std::uint32_t word) {
  const std::size_t largest = word >> 30U;
  std::array<float, 4> q{};
  float rest = 1.0F;
  unsigned shift = 20;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    q[i] = (share(word, shift, 10) - 0.5F) * 1.41421356F;
    rest -= q[i] * q[i];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(rest, 0.0F));
  return q;
}

float unpack_sh(std::uint8_t byte) {
  constexpr float kRange = 8.0F;
  const float t = byte == 0 ? 0.0F : byte == 255 ? 1.0F : (static_cast<float>(byte) + 0.5F) / 256.0F;
  return (t - 0.5F) * kRange;
}

}  // namespace

bool is_compressed_ply(const std::string& bytes) {
  const std::size_t end = bytes.substr(0, kMaxCompressedHeaderBytes).find("\nend_header");
  const std::size_t chunk = bytes.find("\nelement chunk ");
  return bytes.starts_with("ply") && end != std::string::npos && chunk < end;
}

GaussianSet read_compressed_ply(const std::string& bytes, const std::string& file) {
  const Contents c = parse(bytes, file);
  const bool colors = c.chunk_floats > kBounds.size();
  GaussianSet set(SetKind::kCamera, c.sh_degree, static_cast<Eigen::Index>(c.vertices));
  const int higher = sh_coefficients(c.sh_degree) - 1;
  for (std::size_t v = 0; v < c.vertices; ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    const char* const chunk = c.chunk_data + 4 * c.chunk_floats * (v / kChunk);
    const auto position = unpack(word_at(c.vertex_data, 4 * v), chunk, 0);
    const auto rotation = unpack_rotation(word_at(c.vertex_data, 4 * v + 1));
    const auto scale = unpack(word_at(c.vertex_data, 4 * v + 2), chunk, 6);
    const std::uint32_t color = word_at(c.vertex_data, 4 * v + 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<int>(i);
      set.params(row, kMeanRow + k) = position[i];
      set.params(row, kLogScaleRow + k) = scale[i];
      float value = share(color, static_cast<unsigned>(24 - 8 * k), 8);
      if (colors) {
        const float low = float_at(chunk, kBounds.size() + i), high = float_at(chunk, kBounds.size() + 3 + i);
        value = low * (1.0F - value) + high * value;
      }
      set.params(row, kShRow + k) = (value - 0.5F) / kSh0;
    }
    for (std::size_t i = 0; i < 4; ++i) set.params(row, kRotationRow + static_cast<int>(i)) = rotation[i];
    // Steps of 1/255; the ends are half a step away from 0 and 1.
    const float opacity = std::clamp(share(color, 0, 8), 0.5F / 255.0F, 254.5F / 255.0F);
    set.params(row, kOpacityRow) = std::log(opacity / (1.0F - opacity));
    for (int k = 0; k < 3 * higher; ++k) {
      const auto byte = static_cast<std::uint8_t>(
          c.sh_data[static_cast<std::size_t>(3 * higher) * v + static_cast<std::size_t>(k)]);
      set.params(row, kShRow + 3 * (k % higher + 1) + k / higher) = unpack_sh(byte);
    }
  }
  return set;
}

}  // namespace simuli
