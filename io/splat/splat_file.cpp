#include "io/splat/splat_file.hpp"

#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/archive/stored_zip.hpp"
#include "io/base/file.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_axes.hpp"

namespace simuli {

std::vector<std::string> SplatReport::notes() const {
  std::vector<std::string> lines;
  if (left_out > 0) lines.push_back("left out: " + broken_particles(left_out));
  if (is_antialiased)
    lines.emplace_back("trained antialiased: render.camera_compensation=true renders it so");
  return lines;
}

std::string broken_particles(Eigen::Index count) {
  return fmt::format("{} particles with NaN, Inf or a zero quaternion", count);
}

GaussianSet read_splats(const std::filesystem::path& file, SplatReport* report) {
  constexpr std::size_t kMaxFileBytes = std::size_t{16} << 30U;
  return read_splats(read_file(file, kMaxFileBytes), file, report);
}

GaussianSet read_splats(std::string bytes, const std::filesystem::path& file, SplatReport* report) {
  const std::string extension = ending_of(file), name = file.string();
  if (has_other_splat_extension(file))
    throw_input_error(name, "splats", extension, ".ply (also SuperSplat's compressed), .spz or .glb");
  GaussianSet set = extension == ".spz"   ? read_spz(std::move(bytes), name, report)
                    : extension == ".glb" ? read_glb(bytes, name, report)
                                          : parse_gaussians_ply(bytes, SetKind::kCamera, name);
  // Other programs write infinite logits for 0 and 1; they are clamped to the 8-bit limit.
  const float most = std::log(254.5F / 0.5F);
  for (float& opacity : set.opacity_logit()) {
    if (std::isinf(opacity)) opacity = std::copysign(most, opacity);
  }
  if (report != nullptr) report->left_out = leave_out_broken(set);
  if (report != nullptr && set.size() == 0 && report->left_out > 0) {
    throw_input_error(
        name, "particles", fmt::format("{}, none of them sound", report->left_out), "sound ones");
  }
  validate(set, name);
  return set;
}

bool has_splat_extension(const std::filesystem::path& file) {
  const std::string extension = ending_of(file);
  return extension == ".ply" || extension == ".spz" || extension == ".glb";
}

bool has_other_splat_extension(const std::filesystem::path& file) {
  const std::string extension = ending_of(file);
  return extension == ".splat" || extension == ".ksplat" || extension == ".sog";
}

void write_splats(const std::filesystem::path& file, const GaussianSet& set, const SplatOutput& how) {
  const std::string extension = ending_of(file), name = file.string();
  if (how.compress && extension != ".glb") {
    throw_input_error(name, "extension", "another one with compression", ".glb with it");
  }
  if (extension == ".ply") return write_gaussians_ply(file, set);
  if (extension == ".spz") {
    return write_spz(file, turned(set, level_from(SplatAxes::kYDown).conjugate() * level_from(how.axes)));
  }
  if (extension == ".glb") return write_file_atomically(file, glb_of(set, how, name));
  if (extension == ".usda") return write_file_atomically(file, usda_of(set, how.axes, name));
  if (extension == ".usdz") {
    StoredZip zip(name, kUsdzAlignment);
    zip.add(kUsdzLayer, usda_of(set, how.axes, name));
    return write_file_atomically(file, zip.finish());
  }
  throw_input_error(name, "extension", '"' + extension + '"', ".ply, .spz, .glb, .usda or .usdz");
}

}  // namespace simuli
