#pragma once
#include <cstddef>
#include <cstdint>

#include "host/device/render/device/scan.hpp"

namespace simuli {

/// Buffer sizes of a sort in addition to the pairs.
struct SortSizes {
  std::uint64_t pairs = 0;
  std::uint64_t counters = 0;  // digits x work-groups, upper bound
};
struct SortBuffers : BufferTable<SortSizes> {
  using BufferTable::BufferTable;
  Words keys{*this, "sort_keys", [](const SortSizes& s) { return s.pairs; }};
  Words values{*this, "sort_values", [](const SortSizes& s) { return s.pairs; }};
  Words histogram{*this, "histogram", [](const SortSizes& s) { return s.counters; }};
};

class SortStage {
 public:
  /// Work-groups of one work-item sort 11 bits a pass, larger ones (at least 16) 8 bits; 0: chosen for the
  /// device.
  explicit SortStage(const Device& device, std::size_t work_items = 0);
  /// Sorts n pairs stably by the low `bits` of the key.
  void run(Buffer<std::uint32_t>& keys, Buffer<std::uint32_t>& values, std::uint32_t n, int bits);
  /// Returns the buffer sizes for sorting `pairs` pairs, without the pairs.
  [[nodiscard]] static SortSizes sizes(const Device& device, std::uint64_t pairs, std::size_t work_items = 0);
  /// Returns the number of passes of a sort by `bits` bits; a pass reads keys twice and values once, and writes
  /// both.
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
