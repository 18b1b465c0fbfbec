#pragma once
// The steps of procedure 1 on the device; host/device/render/rays/lidar_tiles.cpp puts them together.
#include <cstdint>
#include <vector>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/rays/lidar_tiles.hpp"

namespace simuli {

/// How values fall into bins.
struct TileBins {
  float first = 0.0F;
  float scale = 0.0F;
  std::uint32_t count = 0;
};

/// Values on the device and the bins that they fall into.
struct BinnedValues {
  const Buffer<float>& values;
  TileBins bins;
};

/// Rows that a ray list is cut into.
struct ListRows {
  explicit ListRows(const Device& device)
      : order(device, "rays by row"), starts(device, "row starts"), group_of_row(device, "groups of rows") {}
  Buffer<std::uint32_t> order;         // [rays] by row, the rows from top to bottom
  Buffer<std::uint32_t> starts;        // [rows + 1] into `order`
  Buffer<std::uint32_t> group_of_row;  // [rows] group of elevation
};

class LidarTilingStage {
  using Uints = Buffer<std::uint32_t>;

 public:
  explicit LidarTilingStage(const Device& device);

  /// The group of each bin, `wanted` groups of equally many rays, each of at most `widest` bins.
  Uints groups_of(const Buffer<float>& values,
                  std::uint32_t weight,
                  const TileBins& bins,
                  std::uint32_t wanted,
                  std::uint32_t widest,
                  std::uint32_t& groups);
  /// Rays of the fullest group.
  std::uint32_t fullest_group(const Buffer<float>& values,
                              std::uint32_t weight,
                              const TileBins& bins,
                              const Uints& group_of_bin,
                              std::uint32_t groups);
  Uints groups_of_rows(const Buffer<float>& elevation, const TileBins& bins, const Uints& group_of_bin);
  /// Cuts rows into tile rows of at most `most`; returns the most and leaves the tables on the device.
  std::uint32_t cut(const Uints& group_of_row, std::uint32_t rows, std::uint32_t most, LidarTiles& out);
  /// Most rays of one row in one tile, and of one tile.
  struct Fullest {
    std::uint32_t row = 0;
    std::uint32_t tile = 0;
  };
  /// Works out slot_of_ray().
  Fullest place(const Buffer<float>& x,
                const Uints& order,
                const Uints& row_starts,
                const TileBins& bins,
                const Uints& column_of_bin,
                const LidarTiles& tiling);
  /// Rows of a list, of SIM_RAY_BLOCK rays of a tile column at most; false when they would be more than a
  /// footprint can name. Elevations fall into groups, places into tile columns, of which there are `columns`.
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
