#pragma once
#include <cstddef>
#include <cstdint>

#include "host/render/device/buffer_table.hpp"
#include "host/runtime/kernel.hpp"

namespace simuli {

/// How many work-items share a pass over n elements, and how many consecutive elements each takes.
struct Chunks {
  std::size_t work_items = 0;
  std::uint32_t chunk = 0;
};
[[nodiscard]] Chunks chunks_of(const Device& device, std::size_t n);

struct ScanSizes {};
struct ScanBuffers : BufferTable<ScanSizes> {
  using BufferTable::BufferTable;
  Array<std::uint64_t> total{*this, "scan_total", [](const ScanSizes&) { return std::uint64_t{1}; }};
};

class ScanStage {
 public:
  /// `work_items` share the scan; 0: as suits the device. Tests run the GPU's way on CPUs.
  explicit ScanStage(const Device& device, std::size_t work_items = 0);
  /// Exclusive prefix sum of data[0, n) in place; returns the 64-bit total when `wanted` (waits).
  std::uint64_t run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted);

 private:
  std::size_t work_items_;
  Kernel scan_;
  ScanBuffers buffers_;
};

}  // namespace simuli
