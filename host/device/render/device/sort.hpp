#pragma once
#include <cstddef>
#include <cstdint>

#include "host/device/render/device/scan.hpp"

namespace simuli {

/// What a sort of `pairs` keeps beside them.
struct SortSizes {
  std::uint64_t pairs = 0;
  std::uint64_t counters = 0;  // digits x work-groups, at most
};
struct SortBuffers : BufferTable<SortSizes> {
  using BufferTable::BufferTable;
  Words keys{*this, "sort_keys", [](const SortSizes& s) { return s.pairs; }};
  Words values{*this, "sort_values", [](const SortSizes& s) { return s.pairs; }};
  Words histogram{*this, "histogram", [](const SortSizes& s) { return s.counters; }};
};

class SortStage {
 public:
  /// Work-groups of one work-item sort 11 bits a pass, larger ones (at least 16) 8; 0: as suits the device.
  explicit SortStage(const Device& device, std::size_t work_items = 0);
  /// Sorts n pairs by the low `bits` of the key, stably.
  void run(Buffer<std::uint32_t>& keys, Buffer<std::uint32_t>& values, std::uint32_t n, int bits);
  /// What that many pairs take on a device, the pairs excepted.
  [[nodiscard]] static SortSizes sizes(const Device& device, std::uint64_t pairs, std::size_t work_items = 0);
  /// How often a sort by `bits` goes through the pairs: reads keys twice and values once, and writes both.
  [[nodiscard]] static unsigned passes(const Device& device, int bits, std::size_t work_items = 0);

 private:
  std::size_t work_items_;
  int digit_bits_;
  ScanStage scan_;
  SortBuffers buffers_;
  Kernel count_;
  Kernel scatter_;
};

}  // namespace simuli
