// Launcher of "kernels/ray_mask.cl".
#include "host/device/render/rays/ray_mask.hpp"

#include <algorithm>

namespace simuli {
namespace {

BuildOptions mask_options(Precision precision) {
  BuildOptions options;
  return options.real(precision).define("SENSOR", SensorType::kLidar);
}

/// Partial requests would fill cells of the usual size although these contain one of many rays: they use a row
/// per beam and two columns per firing.
RayMaskSize size_of_mask(const RayGrid& grid, bool all) {
  constexpr RayMaskSize kUsual;
  constexpr int kMostCells = 1 << 20, kMostBeams = 4096;
  if (all) return kUsual;
  const auto firings = static_cast<int>(grid.rays / grid.frame.rows);
  const int rows = std::clamp(static_cast<int>(grid.frame.rows), kUsual.rows, kMostBeams);
  const int columns = std::clamp(2 * firings, kUsual.columns, std::max(kMostCells / rows, kUsual.columns));
  return {columns, rows};
}

std::vector<std::uint32_t> rows_of_mask(const RayGrid& grid, std::size_t mask_rows) {
  std::vector<std::uint32_t> out(grid.frame.rows);
  for (std::size_t row = 0; row < out.size(); ++row)
    out[row] = static_cast<std::uint32_t>(row * mask_rows / out.size());
  return out;
}

}  // namespace

RayMaskStage::RayMaskStage(const Device& device, Precision precision)
    : scratch_(device),
      cells_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_cells"),
      row_sums_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_row_sums"),
      column_sums_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_column_sums") {}

bool RayMaskStage::run(const RayGrid& grid,
                       bool all,
                       const RayLayout& layout,
                       RequestedRays& requested,
                       shared::ModelConstants<double>& model) {
  const RayMaskSize size = size_of_mask(grid, all);
  const auto columns = static_cast<std::uint32_t>(size.columns), rows = static_cast<std::uint32_t>(size.rows);
  model.mask_scale = columns / (model.tile_last - model.tile_first);
  model.mask_columns = columns;
  requested.mask_row_of_row.assign(rows_of_mask(grid, rows));
  scratch_.reserve(size);
  scratch_.cells.fill(0);
  cells_.run_over(grid.frame.slots,
                  {{"frame", grid.frame},
                   layout,
                   requested,
                   {"first", model.tile_first},
                   {"scale", model.mask_scale},
                   {"columns", columns},
                   scratch_});
  requested.areas.reserve((std::size_t{rows} + 1) * (std::size_t{columns} + 1));
  row_sums_.run_over(std::size_t{rows} + 1, {scratch_, {"rows", rows}, {"columns", columns}, requested});
  column_sums_.run_over(std::size_t{columns} + 1, {{"rows", rows}, {"columns", columns}, requested});
  const std::uint32_t marked = requested.areas.read_back(requested.areas.count() - 1);
  return marked < std::size_t{rows} * columns;
}

}  // namespace simuli
