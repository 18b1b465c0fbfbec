#include <Eigen/Geometry>
#include <fmt/format.h>
#include <iostream>

#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/info/info.hpp"
#include "host/core/base/one_line.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

Eigen::AlignedBox3f bounds_of(const GaussianSet& set) {
  return {set.mean().colwise().minCoeff().transpose(), set.mean().colwise().maxCoeff().transpose()};
}

}  // namespace

nlohmann::ordered_json set_json(const GaussianSet& set) {
  nlohmann::ordered_json json = {
      {"particles", set.size()},
      {"sh_degree", set.sh_degree},
      {"parameter_bytes", set.params.size() * static_cast<Eigen::Index>(sizeof(float))}};
  if (set.size() > 0) {
    const Eigen::AlignedBox3f box = bounds_of(set);
    json["mean_min_m"] = {box.min().x(), box.min().y(), box.min().z()};
    json["mean_max_m"] = {box.max().x(), box.max().y(), box.max().z()};
  }
  return json;
}

std::string set_text(const char* name, const GaussianSet& set) {
  return fmt::format("  {} set {} particles, SH degree {}, {:.1f} MB\n",
                     name,
                     set.size(),
                     set.sh_degree,
                     static_cast<double>(set.params.size()) * sizeof(float) / 1e6);
}

void print_splats(const std::filesystem::path& file, bool json) {
  SplatReport report;
  const GaussianSet set = read_splats(file, &report);
  if (json) {
    nlohmann::ordered_json out = {{"kind", "splats"}, {"file", file.string()}};
    out.update(set_json(set));
    out["left_out"] = report.left_out;
    out["notes"] = report.notes();
    std::cout << json_text(out) << '\n';
    return;
  }
  std::cout << fmt::format("splats {}\n", on_one_line(file.string())) << set_text("camera", set);
  for (const std::string& note : report.notes()) std::cout << "  " << note << '\n';
  if (set.size() == 0) return;
  const Eigen::AlignedBox3f box = bounds_of(set);
  std::cout << fmt::format("  from {:.2f}, {:.2f}, {:.2f} to {:.2f}, {:.2f}, {:.2f} in its own units\n",
                           box.min().x(),
                           box.min().y(),
                           box.min().z(),
                           box.max().x(),
                           box.max().y(),
                           box.max().z());
}

}  // namespace simuli::cli
