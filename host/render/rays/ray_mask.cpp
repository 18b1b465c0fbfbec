// Launcher of "kernels/ray_mask.cl".
#include "host/render/rays/ray_mask.hpp"

#include <algorithm>

#include "host/base/fields.hpp"

namespace simuli {
namespace {

BuildOptions mask_options(Precision precision) {
  BuildOptions options;
  return options.real(precision).define("SENSOR", SensorType::kLidar);
}

/// Rows of the mask hold equally many beams, or equal intervals of elevation.
std::vector<std::uint32_t> rows_of_mask(const RayGrid& grid, const RayMaskSize& size) {
  const std::size_t rows = grid.frame.rows;
  const auto mask_rows = static_cast<std::size_t>(size.rows);
  std::vector<std::uint32_t> out(rows);
  const double top = grid.row_elevation[0], bottom = grid.row_elevation[rows - 1];
  for (std::size_t row = 0; row < rows; ++row) {
    const double down = (top - grid.row_elevation[row]) / std::max(top - bottom, 1e-9);
    const std::size_t at = size.equalized ? row * mask_rows / rows
                                          : static_cast<std::size_t>(down * static_cast<double>(mask_rows));
    out[row] = static_cast<std::uint32_t>(std::min(at, mask_rows - 1));
  }
  return out;
}

}  // namespace

RayMaskStage::RayMaskStage(const Device& device, Precision precision)
    : scratch_(device),
      cells_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_cells"),
      row_sums_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_row_sums"),
      column_sums_(Program(device, "kernels/ray_mask.cl", mask_options(precision)), "ray_mask_column_sums") {}

bool RayMaskStage::run(RayGrid& grid, const RayMaskSize& size, RayBuffers& rays) {
  check_fields(size);
  const auto columns = static_cast<std::uint32_t>(size.columns), rows = static_cast<std::uint32_t>(size.rows);
  auto& m = grid.model;
  m.mask_scale = columns / (m.tile_last - m.tile_first);
  m.mask_columns = columns;
  rays.mask_row_of_row.assign(rows_of_mask(grid, size));
  scratch_.reserve(size);
  scratch_.cells.fill(0);
  cells_.run_over(grid.frame.slots,
                  {{"frame", grid.frame},
                   rays,
                   {"first", m.tile_first},
                   {"scale", m.mask_scale},
                   {"columns", columns},
                   scratch_});
  rays.areas.reserve((std::size_t{rows} + 1) * (std::size_t{columns} + 1));
  row_sums_.run_over(std::size_t{rows} + 1, {scratch_, {"rows", rows}, {"columns", columns}, rays});
  column_sums_.run_over(std::size_t{columns} + 1, {{"rows", rows}, {"columns", columns}, rays});
  return rays.areas.read_back(rays.areas.count() - 1) < std::size_t{rows} * columns;
}

}  // namespace simuli
