// Launcher of "kernels/lidar_tiling.cl".
#include "host/device/render/rays/lidar_tiling.hpp"

#include <algorithm>
#include <numeric>

namespace simuli {

using Uints = Buffer<std::uint32_t>;

namespace {

std::vector<std::uint32_t> front(const Uints& buffer, std::size_t count) {
  std::vector<std::uint32_t> values(count);
  buffer.download_at(0, values);
  return values;
}

std::uint32_t most(const Uints& buffer) {
  const std::vector<std::uint32_t> all = buffer.download();
  return *std::max_element(all.begin(), all.end());
}

}  // namespace

LidarTilingStage::LidarTilingStage(const Device& device)
    : device_(device),
      program_(device, "kernels/lidar_tiling.cl"),
      scan_(device),
      sort_(device),
      histogram_(program_, "tiling_histogram"),
      boundaries_(program_, "tiling_boundaries"),
      row_groups_(program_, "tiling_row_groups"),
      keys_(program_, "tiling_keys"),
      list_rows_(program_, "tiling_list_rows"),
      tile_rows_(program_, "tiling_tile_rows"),
      slots_(program_, "tiling_slots"),
      fullest_tiles_(program_, "tiling_fullest_tiles"),
      found_(device, "tile rows found", 3) {}

Uints LidarTilingStage::groups_of(const Buffer<float>& values,
                                  std::uint32_t weight,
                                  const TileBins& bins,
                                  std::uint32_t wanted,
                                  std::uint32_t widest,
                                  std::uint32_t& groups) {
  const auto n = static_cast<std::uint32_t>(values.count());
  Uints identity(device_, "bins", iota(bins.count));
  Uints counts(device_, "rays of bins", bins.count);
  counts.fill(0);
  count(values, n, weight, bins, identity, counts);
  scan_.run(counts, bins.count, false);
  Uints group_of_bin(device_, "groups of bins", bins.count);
  boundaries_.run(1,
                  1,
                  {{"before", counts},
                   {"rays", n * weight},
                   {"bins", bins.count},
                   {"wanted", wanted},
                   {"widest", widest},
                   {"group_of_bin", group_of_bin},
                   {"groups", found_}});
  groups = found_.read_back();
  return group_of_bin;
}

std::uint32_t LidarTilingStage::fullest_group(const Buffer<float>& values,
                                              std::uint32_t weight,
                                              const TileBins& bins,
                                              const Uints& group_of_bin,
                                              std::uint32_t groups) {
  Uints counts(device_, "rays of groups", groups);
  counts.fill(0);
  count(values, static_cast<std::uint32_t>(values.count()), weight, bins, group_of_bin, counts);
  return most(counts);
}

Uints LidarTilingStage::groups_of_rows(const Buffer<float>& elevation,
                                       const TileBins& bins,
                                       const Uints& group_of_bin) {
  const auto rows = static_cast<std::uint32_t>(elevation.count());
  Uints group_of_row(device_, "groups of rows", rows);
  row_groups_.run_over(rows,
                       {{"row_elevation", elevation},
                        {"rows", rows},
                        {"first", bins.first},
                        {"scale", bins.scale},
                        {"bins", bins.count},
                        {"group_of_bin", group_of_bin},
                        {"group_of_row", group_of_row}});
  return group_of_row;
}

std::uint32_t LidarTilingStage::cut(const Uints& group_of_row,
                                    std::uint32_t rows,
                                    std::uint32_t most,
                                    LidarTiles& out) {
  first_rows_.reserve(std::size_t{rows} + 1);
  tile_row_of_row_.reserve(rows);
  tile_rows_.run(1,
                 1,
                 {{"group_of_row", group_of_row},
                  {"rows", rows},
                  {"most", most},
                  {"tile_rows", first_rows_},
                  {"tile_row_of_row", tile_row_of_row_},
                  {"found", found_}});
  const std::vector<std::uint32_t> found = found_.download();
  out.tile_rows = front(first_rows_, std::size_t{found[0]} + 1);
  out.tile_row_of_row = tile_row_of_row_.download();
  return found[1];
}

LidarTilingStage::Fullest LidarTilingStage::place(const Buffer<float>& x,
                                                  const Uints& order,
                                                  const Uints& row_starts,
                                                  const TileBins& bins,
                                                  const Uints& column_of_bin,
                                                  const LidarTiles& tiling) {
  const auto rows = static_cast<std::uint32_t>(tiling.rows());
  used_.reserve(std::size_t{rows} * tiling.columns);
  slot_of_ray_.reserve(x.count());
  fullest_.reserve(rows);
  slots_.run(rows,
             1,
             {{"x", x},
              {"order", order},
              {"row_starts", row_starts},
              {"rows", rows},
              {"first", bins.first},
              {"scale", bins.scale},
              {"bins", bins.count},
              {"column_of_bin", column_of_bin},
              {"columns", tiling.columns},
              {"tile_rows", first_rows_},
              {"tile_row_of_row", tile_row_of_row_},
              {"width", tiling.row_slots * SIM_RAY_BLOCK},
              {"tile_rays", std::uint32_t{SIM_TILE_RAYS}},
              {"used", used_},
              {"slot_of_ray", slot_of_ray_},
              {"fullest", fullest_}});
  Fullest fullest{most(fullest_), 0};
  const auto tiles = static_cast<std::uint32_t>(tiling.tile_rows.size() - 1);
  fullest_.reserve(tiles);
  fullest_tiles_.run(tiles,
                     1,
                     {{"used", used_},
                      {"tile_rows", first_rows_},
                      {"tiles", tiles},
                      {"columns", tiling.columns},
                      {"fullest", fullest_}});
  fullest.tile = most(fullest_);
  return fullest;
}

bool LidarTilingStage::list_rows(const BinnedValues& elevation,
                                 const Uints& group_of_bin,
                                 const BinnedValues& x,
                                 const Uints& column_of_bin,
                                 std::uint32_t columns,
                                 ListRows& rows) {
  const auto n = static_cast<std::uint32_t>(elevation.values.count());
  Uints keys(device_, "elevation keys", n);
  rows.order.reserve(n);
  keys_.run_over(n, {{"elevation", elevation.values}, {"n", n}, {"keys", keys}, {"order", rows.order}});
  sort_.run(keys, rows.order, n, 32);
  const std::uint32_t most_rows = std::min(n, std::uint32_t{LidarTiles::kMostRows});
  rows.starts.reserve(std::size_t{most_rows} + 1);
  rows.group_of_row.reserve(most_rows);
  used_.reserve(std::size_t{2} * columns);
  list_rows_.run(1,
                 1,
                 {{"order", rows.order},
                  {"n", n},
                  {"x", x.values},
                  {"x_first", x.bins.first},
                  {"x_scale", x.bins.scale},
                  {"x_bins", x.bins.count},
                  {"column_of_bin", column_of_bin},
                  {"columns", columns},
                  {"elevation", elevation.values},
                  {"first", elevation.bins.first},
                  {"scale", elevation.bins.scale},
                  {"bins", elevation.bins.count},
                  {"group_of_bin", group_of_bin},
                  {"width", std::uint32_t{SIM_RAY_BLOCK}},
                  {"most_rows", most_rows},
                  {"used", used_},
                  {"row_starts", rows.starts},
                  {"group_of_row", rows.group_of_row},
                  {"rows", found_}});
  const std::uint32_t found = found_.read_back();
  if (found > most_rows) return false;
  rows.starts.reserve(std::size_t{found} + 1);
  rows.group_of_row.reserve(found);
  return true;
}

std::vector<std::uint32_t> LidarTilingStage::slot_of_ray() const { return slot_of_ray_.download(); }

std::vector<std::uint32_t> LidarTilingStage::iota(std::uint32_t count) {
  std::vector<std::uint32_t> values(count);
  std::iota(values.begin(), values.end(), 0U);
  return values;
}

void LidarTilingStage::count(const Buffer<float>& values,
                             std::uint32_t n,
                             std::uint32_t weight,
                             const TileBins& bins,
                             const Uints& group_of_bin,
                             Uints& counts) {
  histogram_.run_over(n,
                      {{"values", values},
                       {"n", n},
                       {"weight", weight},
                       {"first", bins.first},
                       {"scale", bins.scale},
                       {"bins", bins.count},
                       {"group_of_bin", group_of_bin},
                       {"counts", counts}});
}

}  // namespace simuli
