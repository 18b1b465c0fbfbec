#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string_view>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/ply_header.hpp"
#include "io/splat/ply_layout.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 30U;

/// One column of GaussianSet::params (kActorColumn: GaussianSet::actor) and its property.
struct Source {
  std::size_t property;
  int column;
};

constexpr int kActorColumn = -2;

[[noreturn]] void refuse_value(const std::string& file,
                               const std::string& property,
                               std::uint64_t vertex,
                               std::string_view found,
                               std::string_view allowed) {
  throw_input_error(file, fmt::format("vertex {}: {}", vertex, property), found, allowed);
}

/// Returns the SH degree from the number of f_rest properties, which must be contiguous.
int find_sh_degree(const PlyHeader& header, const std::string& file) {
  const auto count = std::count_if(header.properties.begin(), header.properties.end(), [](const auto& p) {
    return p.name.starts_with("f_rest_");
  });
  for (int degree = 0; degree <= 3; ++degree) {
    if (count == 3 * (sh_coefficients(degree) - 1)) return degree;
  }
  throw_input_error(file, "f_rest properties", fmt::format("{}", count), "0, 9, 24 or 45 (SH degree 0 to 3)");
}

void check_channels(const PlyHeader& header, SetKind kind, const std::string& file) {
  for (const std::string& comment : header.comments) {
    if (comment.starts_with("simuli channels") && comment != ply_channels_comment(kind)) {
      throw_input_error(file, "channels", '"' + comment + '"', '"' + ply_channels_comment(kind) + '"');
    }
  }
}

std::vector<Source> find_sources(const PlyHeader& header, int sh_degree, const std::string& file) {
  if (header.find("scale_1") >= 0 && header.find("scale_2") < 0) {
    throw_input_error(file,
                      "scale properties",
                      "2 (flat discs of 2D Gaussians)",
                      "scale_0, scale_1, scale_2 (3D Gaussians)");
  }
  std::vector<Source> sources;
  for (const auto& [name, column] : ply_gaussian_columns(sh_degree)) {
    const int property = header.find(name);
    if (property < 0) throw_input_error(file, "property " + name, "none", "one scalar property of that name");
    sources.push_back({static_cast<std::size_t>(property), column});
  }
  const int actor = header.find(kPlyActor);
  if (actor >= 0) sources.push_back({static_cast<std::size_t>(actor), kActorColumn});
  return sources;
}

template <class T>
double decode(const char* at, bool swap) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double decode(PlyType type, const char* at, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return decode<std::int8_t>(at, swap);
    case PlyType::kUint8:
      return decode<std::uint8_t>(at, swap);
    case PlyType::kInt16:
      return decode<std::int16_t>(at, swap);
    case PlyType::kUint16:
      return decode<std::uint16_t>(at, swap);
    case PlyType::kInt32:
      return decode<std::int32_t>(at, swap);
    case PlyType::kUint32:
      return decode<std::uint32_t>(at, swap);
    case PlyType::kFloat32:
      return decode<float>(at, swap);
    case PlyType::kFloat64:
      return decode<double>(at, swap);
  }
  throw Error(ErrorKind::kInternal, "PLY type without a decoder");
}

/// Converts back to float; floats read as double are exact, larger values become Inf.
float to_float(double value) {
  if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    return std::copysign(std::numeric_limits<float>::infinity(),
                         static_cast<float>(std::copysign(1.0, value)));
  }
  return static_cast<float>(value);
}

void store(double value,
           int column,
           const std::string& file,
           const std::string& property,
           std::uint64_t vertex,
           GaussianSet& set) {
  if (column != kActorColumn) {
    set.params(static_cast<Eigen::Index>(vertex), column) = to_float(value);
    return;
  }
  if (!(value >= 0.0 && value <= std::numeric_limits<std::uint32_t>::max() && value == std::floor(value))) {
    refuse_value(file, property, vertex, fmt::format("{}", value), "a whole number, 0 or more");
  }
  set.actor[vertex] = static_cast<std::uint32_t>(value);
}

void read_binary(const std::string& bytes,
                 const PlyHeader& header,
                 const std::vector<Source>& sources,
                 const std::string& file,
                 GaussianSet& set) {
  const bool file_is_little = header.format == PlyFormat::kLittleEndian;
  const bool swap = file_is_little != (std::endian::native == std::endian::little);
  for (std::uint64_t v = 0; v < header.vertices; ++v) {
    const char* vertex = bytes.data() + header.body + header.bytes_in_front + v * header.vertex_bytes;
    for (const Source& source : sources) {
      const PlyProperty& property = header.properties[source.property];
      store(
          decode(property.type, vertex + property.offset, swap), source.column, file, property.name, v, set);
    }
  }
}

/// Values of an ascii body. std::from_chars is independent of the locale.
class AsciiValues {
 public:
  AsciiValues(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  double next(const std::string& property, std::uint64_t vertex) {
    skip_blanks();
    if (at_ == text_.size()) refuse_value(file_, property, vertex, "the end of the file", "a number");
    const std::size_t end = std::min(text_.find_first_of(kBlanks, at_), text_.size());
    std::string_view word = text_.substr(at_, end - at_);
    at_ = end;
    if (word.size() > 1 && word.front() == '+') word.remove_prefix(1);
    double value = 0.0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (stop != word.data() + word.size() || error == std::errc::invalid_argument) {
      refuse_value(file_, property, vertex, "a word that is no number", "a number");
    }
    // Outside of double's range: too large, or too small to represent.
    if (error == std::errc::result_out_of_range) {
      return word.find("e-") == std::string_view::npos && word.find("E-") == std::string_view::npos
                 ? std::numeric_limits<double>::infinity()
                 : 0.0;
    }
    return value;
  }
  [[nodiscard]] bool at_end() {
    skip_blanks();
    return at_ == text_.size();
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\n";
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size()); }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
};

void read_ascii(const std::string& bytes,
                const PlyHeader& header,
                const std::vector<Source>& sources,
                const std::string& file,
                GaussianSet& set) {
  constexpr int kUnused = -1;
  std::vector<int> columns(header.properties.size(), kUnused);
  for (const Source& source : sources) columns[source.property] = source.column;
  AsciiValues values(std::string_view(bytes).substr(header.body), file);
  for (std::uint64_t i = 0; i < header.values_in_front; ++i) (void)values.next("element in front", 0);
  for (std::uint64_t v = 0; v < header.vertices; ++v) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string& name = header.properties[i].name;
      const double value = values.next(name, v);
      if (columns[i] != kUnused) store(value, columns[i], file, name, v, set);
    }
  }
  if (!header.other_elements && !values.at_end()) {
    throw_input_error(file,
                      "element vertex",
                      fmt::format("{} vertices and more values behind them", header.vertices),
                      "nothing behind the last vertex");
  }
}

/// Reads the body in its format.
void read_body(const std::string& bytes,
               const PlyHeader& header,
               const std::vector<Source>& sources,
               const std::string& file,
               GaussianSet& set) {
  if (header.format == PlyFormat::kAscii) {
    read_ascii(bytes, header, sources, file, set);
  } else {
    read_binary(bytes, header, sources, file, set);
  }
}

/// Applies Mip-Splatting's 3D filter, whose width is stored with the particles: it widens and dims them.
void apply_filter(const std::string& bytes,
                  const PlyHeader& header,
                  const std::string& file,
                  GaussianSet& set) {
  const int property = header.find("filter_3D");
  if (property < 0) return;
  GaussianSet filter(SetKind::kCamera, 0, set.size());
  read_body(bytes, header, {{static_cast<std::size_t>(property), kMeanRow}}, file, filter);
  const Eigen::ArrayX3d own = (2.0 * set.log_scale().cast<double>().array()).exp();
  const Eigen::ArrayX3d both = own.colwise() + filter.mean().col(0).cast<double>().array().square();
  const Eigen::ArrayXd opacity =
      (own / both).rowwise().prod().sqrt() / (1.0 + (-set.opacity_logit().cast<double>().array()).exp());
  set.log_scale() = (0.5 * both.log()).cast<float>().matrix();
  set.opacity_logit() = (opacity / (1.0 - opacity)).log().cast<float>().matrix();
}

}  // namespace

GaussianSet read_gaussians_ply(const std::filesystem::path& file, SetKind kind) {
  return read_gaussians_ply(read_file(file, kMaxFileBytes), kind, file.string());
}

GaussianSet read_gaussians_ply(const std::string& bytes, SetKind kind, const std::string& file) {
  GaussianSet set = parse_gaussians_ply(bytes, kind, file);
  validate(set, file);
  return set;
}

GaussianSet parse_gaussians_ply(const std::string& bytes, SetKind kind, const std::string& file) {
  if (is_compressed_ply(bytes)) {
    if (kind == SetKind::kCamera) return read_compressed_ply(bytes, file);
    throw_input_error(
        file, "channels", "a compressed PLY of colours", '"' + ply_channels_comment(kind) + '"');
  }
  const PlyHeader header = parse_ply_header(bytes, file);
  check_channels(header, kind, file);
  const int sh_degree = find_sh_degree(header, file);
  const std::vector<Source> sources = find_sources(header, sh_degree, file);
  GaussianSet set(kind, sh_degree, static_cast<Eigen::Index>(header.vertices));
  if (header.find(kPlyActor) >= 0) set.actor.resize(header.vertices);
  read_body(bytes, header, sources, file, set);
  apply_filter(bytes, header, file, set);
  return set;
}

std::vector<Eigen::Vector3d> read_points_ply(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string bytes = read_file(file, kMaxFileBytes);
  const PlyHeader header = parse_ply_header(bytes, name);
  std::vector<Source> sources;
  for (const auto& [axis, column] :
       {std::pair<const char*, int>{"x", kMeanRow}, {"y", kMeanRow + 1}, {"z", kMeanRow + 2}}) {
    const int property = header.find(axis);
    if (property < 0) {
      throw_input_error(name, std::string("property ") + axis, "none", "one scalar property of that name");
    }
    sources.push_back({static_cast<std::size_t>(property), column});
  }
  GaussianSet set(SetKind::kCamera, 0, static_cast<Eigen::Index>(header.vertices));
  read_body(bytes, header, sources, name, set);
  std::vector<Eigen::Vector3d> points;
  for (Eigen::Index v = 0; v < set.size(); ++v) {
    points.emplace_back(set.mean().row(v).cast<double>().transpose());
  }
  return points;
}

}  // namespace simuli
