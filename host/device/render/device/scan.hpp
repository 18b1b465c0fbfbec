#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>

#include "host/device/render/device/buffer_table.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// Division of n elements among work-items: their number, group size, and consecutive elements of each; those
/// of the last group may have none.
struct Chunks {
  std::size_t work_items = 0;  // a multiple of `group`
  std::size_t group = 1;
  std::uint32_t chunk = 0;
};
/// `group`: work-items per group, 0: chosen for the device.
[[nodiscard]] Chunks chunks_of(const Device& device, std::size_t n, std::size_t group = 0);

struct ScanSizes {
  std::uint64_t groups = 1;
};
struct ScanBuffers : BufferTable<ScanSizes> {
  using BufferTable::BufferTable;
  Array<std::uint64_t> sums{*this, "scan_sums", [](const ScanSizes& s) { return s.groups; }};
  Array<std::uint64_t> total{*this, "scan_total", [](const ScanSizes&) { return std::uint64_t{2}; }};
};

class ScanStage {
 public:
  /// Uses groups of `work_items`; 0: chosen for the device. Tests run the GPU configuration on CPUs.
  explicit ScanStage(const Device& device, std::size_t work_items = 0);
  /// Computes the exclusive prefix sum of data[0, n) in place; returns the 64-bit total if `wanted` (waits).
  std::uint64_t run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted);
  /// For two consecutive lists in data[0, 2 n): replaces the first by its exclusive prefix sum and destroys the
  /// second; returns both totals, the first within 32 bits (waits once).
  std::pair<std::uint32_t, std::uint64_t> run_two(Buffer<std::uint32_t>& data, std::uint32_t n);
  /// Returns the buffer sizes for a list of n elements.
  [[nodiscard]] static ScanSizes sizes(const Device& device, std::uint64_t n, std::size_t work_items = 0);

 private:
  void launch(Buffer<std::uint32_t>& data, std::uint32_t n, std::uint32_t middle);
  std::size_t work_items_;
  Kernel sums_;
  Kernel scan_;
  ScanBuffers buffers_;
};

}  // namespace simuli
