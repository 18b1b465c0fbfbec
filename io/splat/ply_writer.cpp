#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <fstream>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "io/base/file.hpp"
#include "io/splat/cloud_columns.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/ply_layout.hpp"

namespace simuli {
namespace {

void append_little_endian(std::string& to, std::uint32_t bits) {
  for (unsigned shift = 0; shift < 32; shift += 8) to.push_back(static_cast<char>((bits >> shift) & 0xffU));
}

void append_little_endian(std::string& to, float value) {
  append_little_endian(to, std::bit_cast<std::uint32_t>(value));
}

std::string header(Eigen::Index count,
                   const std::vector<std::string>& properties,
                   const std::string& comment,
                   bool with_actors = false) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  if (!comment.empty()) text += "comment " + comment + '\n';
  text += fmt::format("element vertex {}\n", count);
  for (const std::string& property : properties) text += "property " + property + '\n';
  if (with_actors) text += fmt::format("property uint {}\n", kPlyActor);
  return text + "end_header\n";
}

/// Writes `count` rows; append_row(text, row) appends the bytes of one row. Writes blocks of some megabytes, so
/// that large sets are not duplicated in memory.
template <class AppendRow>
void write_rows(const std::filesystem::path& file,
                const std::string& head,
                Eigen::Index count,
                const AppendRow& append_row) {
  constexpr std::size_t kChunkBytes = std::size_t{4} << 20U;
  write_atomically(file, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    std::string chunk = head;
    for (Eigen::Index row = 0; row < count; ++row) {
      append_row(chunk, row);
      if (chunk.size() < kChunkBytes) continue;
      out.write(chunk.data(), static_cast<std::streamsize>(chunk.size()));
      chunk.clear();
      Interruption::ask();
    }
    out.write(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    out.close();
    if (!out)
      throw_input_error(file.string(), "content", "a write error", "a path and disk that can be written");
  });
}

}  // namespace

void validate(const GaussianSet& set, const std::string& file) {
  if (set.sh_degree < 0 || set.sh_degree > 3 || set.params.cols() != param_rows(set.sh_degree)) {
    throw_input_error(file,
                      "parameters",
                      fmt::format("{} columns at SH degree {}", set.params.cols(), set.sh_degree),
                      "SH degree 0 to 3 and the columns that belong to it");
  }
  if (!set.actor.empty() && static_cast<Eigen::Index>(set.actor.size()) != set.size()) {
    throw_input_error(file,
                      "actor",
                      fmt::format("{} of {} particles", set.actor.size(), set.size()),
                      "one per particle, or none");
  }
  for (const auto& [name, column] : ply_gaussian_columns(set.sh_degree)) {
    for (Eigen::Index v = 0; v < set.size(); ++v) {
      if (std::isfinite(set.params(v, column))) continue;
      throw_input_error(file, fmt::format("vertex {}: {}", v, name), "NaN or Inf", "a finite number");
    }
  }
  for (Eigen::Index v = 0; v < set.size(); ++v) {
    if (set.rotation().row(v).cwiseAbs().maxCoeff() > 0.0F) continue;
    throw_input_error(file, fmt::format("vertex {}: rot_0 to rot_3", v), "a zero quaternion", "a rotation");
  }
}

Eigen::Index leave_out_broken(GaussianSet& set) {
  const auto actors = !set.actor.empty();
  Eigen::Index kept = 0;
  for (Eigen::Index v = 0; v < set.size(); ++v) {
    const bool is_sound = set.params.row(v).allFinite() && set.rotation().row(v).cwiseAbs().maxCoeff() > 0.0F;
    if (!is_sound) continue;
    if (kept != v) set.params.row(kept) = set.params.row(v);
    if (actors) set.actor[static_cast<std::size_t>(kept)] = set.actor[static_cast<std::size_t>(v)];
    ++kept;
  }
  const Eigen::Index broken = set.size() - kept;
  if (broken == 0) return 0;
  set.params.conservativeResize(kept, Eigen::NoChange);
  if (actors) set.actor.resize(static_cast<std::size_t>(kept));
  return broken;
}

void write_gaussians_ply(const std::filesystem::path& file, const GaussianSet& set) {
  validate(set, file.string());
  const auto columns = ply_gaussian_columns(set.sh_degree);
  std::vector<std::string> names;
  for (const auto& [name, column] : columns) {
    names.push_back("float " + name);
    if (name == "z") names.insert(names.end(), {"float nx", "float ny", "float nz"});
  }
  const std::string head = header(set.size(), names, ply_channels_comment(set.kind), !set.actor.empty());
  write_rows(file, head, set.size(), [&](std::string& to, Eigen::Index v) {
    for (const auto& [name, column] : columns) {
      append_little_endian(to, set.params(v, column));
      if (column != kMeanRow + 2) continue;
      for (int i = 0; i < 3; ++i) append_little_endian(to, 0.0F);  // normals, which other programs expect
    }
    if (!set.actor.empty()) append_little_endian(to, set.actor[static_cast<std::size_t>(v)]);
  });
}

void validate(const PointCloud& cloud, const std::string& file) {
  const auto& names = cloud.columns;
  if (static_cast<Eigen::Index>(names.size()) != cloud.values.cols()) {
    throw_input_error(file,
                      "columns",
                      fmt::format("{} names for {} columns", names.size(), cloud.values.cols()),
                      "one name per column");
  }
  if (!cloud.types.empty() && cloud.types.size() != names.size()) {
    throw_input_error(file,
                      "types",
                      fmt::format("{} types for {} columns", cloud.types.size(), names.size()),
                      "one type per column");
  }
  for (const char* needed : {"x", "y", "z"}) {
    if (std::count(names.begin(), names.end(), needed) != 1) {
      throw_input_error(file, "columns", fmt::format("no single {}", needed), "x, y and z once each");
    }
  }
  for (std::size_t c = 0; c < names.size(); ++c) {
    const bool plain = !names[c].empty() && std::all_of(names[c].begin(), names[c].end(), [](char letter) {
      return letter > ' ' && letter <= '~';
    });
    if (!plain || std::count(names.begin(), names.end(), names[c]) != 1) {
      throw_input_error(
          file, fmt::format("columns[{}]", c), '"' + names[c] + '"', "distinct names without blanks");
    }
    const bool is_count = cloud.type(c) == ColumnType::kUint16;
    for (Eigen::Index v = 0; v < cloud.values.rows(); ++v) {
      const double value = cloud.values(v, static_cast<Eigen::Index>(c));
      const bool is_held = is_count ? value >= 0.0 && value <= 65535.0 && value == std::floor(value)
                           : cloud.type(c) == ColumnType::kDouble ? std::isfinite(value)
                                                                  : std::isfinite(static_cast<float>(value));
      if (is_held) continue;
      throw_input_error(file,
                        fmt::format("vertex {}: {}", v, names[c]),
                        std::isfinite(value) ? fmt::format("{}", value) : "NaN or Inf",
                        is_count ? "0 to 65535" : "a finite number");
    }
  }
}

void write_point_cloud_ply(const std::filesystem::path& file, const PointCloud& cloud) {
  validate(cloud, file.string());
  std::vector<std::string> properties;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    properties.push_back(fmt::format("{} {}", format_of(cloud.type(c)).ply, cloud.columns[c]));
  }
  write_rows(file,
             header(cloud.values.rows(), properties, ""),
             cloud.values.rows(),
             [&](std::string& to, Eigen::Index v) { append_point(to, cloud, v); });
}

}  // namespace simuli
