#pragma once
// The device steps of procedure 1; host/device/render/rays/lidar_tiles.cpp combines them.
#include <cstdint>
#include <vector>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/rays/lidar_tiles.hpp"

namespace simuli {

/// Mapping of values to bins.
struct TileBins {
  float first = 0.0F;
  float scale = 0.0F;
  std::uint32_t count = 0;
};

/// Values on the device and their bins.
struct BinnedValues {
  const Buffer<float>& values;
  TileBins bins;
};

/// Rows cut from a ray list.
struct ListRows {
  explicit ListRows(const Device& device)
      : order(device, "rays by row"), starts(device, "row starts"), group_of_row(device, "groups of rows") {}
  Buffer<std::uint32_t> order;  // [rays] by row, rows from top to bottom
  Buffer<std::uint32_t> starts;        // [rows + 1] into `order`
  Buffer<std::uint32_t> group_of_row;  // [rows] elevation group
};

class LidarTilingStage {
  using Uints = Buffer<std::uint32_t>;

 public:
  explicit LidarTilingStage(const Device& device);

  /// Returns the group of each bin: `wanted` groups with equal numbers of rays, each of at most `widest` bins.
  Uints groups_of(const Buffer<float>& values,
                  std::uint32_t weight,
                  const TileBins& bins,
                  std::uint32_t wanted,
                  std::uint32_t widest,
                  std::uint32_t& groups);
  /// Returns the number of rays in the fullest group.
  std::uint32_t fullest_group(const Buffer<float>& values,
                              std::uint32_t weight,
                              const TileBins& bins,
                              const Uints& group_of_bin,
                              std::uint32_t groups);
  Uints groups_of_rows(const Buffer<float>& elevation, const TileBins& bins, const Uints& group_of_bin);
  /// Cuts rows into tile rows of at most `most` rows; returns the largest number and keeps the tables on the
  /// device.
  std::uint32_t cut(const Uints& group_of_row, std::uint32_t rows, std::uint32_t most, LidarTiles& out);
  /// Largest number of rays of one row in one tile, and of one tile.
  struct Fullest {
    std::uint32_t row = 0;
    std::uint32_t tile = 0;
  };
  /// Computes slot_of_ray().
  Fullest place(const Buffer<float>& x,
                const Uints& order,
                const Uints& row_starts,
                const TileBins& bins,
                const Uints& column_of_bin,
                const LidarTiles& tiling);
  /// Cuts a list into rows with at most SIM_RAY_BLOCK rays per tile column; false when footprints cannot
  /// address that many rows. Elevations map to groups, positions to `columns` tile columns.
  bool list_rows(const BinnedValues& elevation,
                 const Uints& group_of_bin,
                 const BinnedValues& x,
                 const Uints& column_of_bin,
                 std::uint32_t columns,
                 ListRows& rows);
  std::vector<std::uint32_t> slot_of_ray() const;
  static std::vector<std::uint32_t> iota(std::uint32_t count);

 private:
  void count(const Buffer<float>& values,
             std::uint32_t n,
             std::uint32_t weight,
             const TileBins& bins,
             const Uints& group_of_bin,
             Uints& counts);

  Device device_;
  Program program_;
  ScanStage scan_;
  SortStage sort_;
  Kernel histogram_, boundaries_, row_groups_, keys_, list_rows_, tile_rows_, slots_, fullest_tiles_;
  Uints found_;
  Uints first_rows_{device_, "first rows"}, tile_row_of_row_{device_, "tile rows of rows"};
  Uints used_{device_, "rays of cells"}, fullest_{device_, "fullest cells"};
  Uints slot_of_ray_{device_, "slots of rays"};
};

}  // namespace simuli
