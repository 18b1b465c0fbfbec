#include "io/splat/splat_file.hpp"

#include <utility>

#include "host/core/base/error.hpp"
#include "io/archive/stored_zip.hpp"
#include "io/base/file.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_axes.hpp"

namespace simuli {

GaussianSet read_splats(const std::filesystem::path& file) {
  if (file.extension() == ".spz") return read_spz(file);
  if (file.extension() == ".glb") return read_glb(read_file(file), file.string());
  return read_gaussians_ply(file, SetKind::kCamera);
}

GaussianSet read_splats(std::string bytes, const std::filesystem::path& file) {
  if (file.extension() == ".spz") return read_spz(std::move(bytes), file.string());
  if (file.extension() == ".glb") return read_glb(bytes, file.string());
  return read_gaussians_ply(bytes, SetKind::kCamera, file.string());
}

bool has_splat_extension(const std::filesystem::path& file) {
  const std::filesystem::path extension = file.extension();
  return extension == ".ply" || extension == ".spz" || extension == ".glb";
}

void write_splats(const std::filesystem::path& file, const GaussianSet& set, const SplatOutput& how) {
  const std::string extension = file.extension().string(), name = file.string();
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
