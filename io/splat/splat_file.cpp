#include "io/splat/splat_file.hpp"

#include <utility>

#include "host/base/error.hpp"
#include "io/splat/ply.hpp"

namespace simuli {

GaussianSet read_splats(const std::filesystem::path& file) {
  return file.extension() == ".spz" ? read_spz(file) : read_gaussians_ply(file, SetKind::kCamera);
}

GaussianSet read_splats(std::string bytes, const std::filesystem::path& file) {
  return file.extension() == ".spz" ? read_spz(std::move(bytes), file.string())
                                    : read_gaussians_ply(bytes, SetKind::kCamera, file.string());
}

void write_splats(const std::filesystem::path& file, const GaussianSet& set) {
  if (file.extension() == ".spz") return write_spz(file, set);
  if (file.extension() == ".ply") return write_gaussians_ply(file, set);
  throw_input_error(file.string(), "extension", '"' + file.extension().string() + '"', ".ply or .spz");
}

}  // namespace simuli
