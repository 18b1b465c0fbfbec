// Launcher of "kernels/sort.cl".
#include <algorithm>

#include "host/render/frame/stages.hpp"

namespace simuli {
namespace {

BuildOptions sort_options(std::size_t work_items, int digit_bits) {
  BuildOptions options;
  return options.define("LS", work_items).define("RADIX_BITS", digit_bits);
}

}  // namespace

SortStage::SortStage(const Device& device, std::size_t work_items)
    : work_items_(work_items != 0        ? work_items
                  : device.info().is_cpu ? 1
                                         : 64),
      digit_bits_(work_items_ == 1 ? 11 : 4),
      groups_(device.info().compute_units * (work_items_ == 1 ? 2U : 16U)),
      histogram_(device, "radix histogram", (std::size_t{1} << static_cast<unsigned>(digit_bits_)) * groups_),
      count_(Program(device, "kernels/sort.cl", sort_options(work_items_, digit_bits_)), "radix_count"),
      scatter_(Program(device, "kernels/sort.cl", sort_options(work_items_, digit_bits_)), "radix_scatter") {}

void SortStage::run(Buffer<std::uint32_t>& keys,
                    Buffer<std::uint32_t>& values,
                    Buffer<std::uint32_t>& key_scratch,
                    Buffer<std::uint32_t>& value_scratch,
                    std::uint32_t n,
                    int bits,
                    ScanStage& scan) {
  if (n == 0) return;
  key_scratch.reserve(n);
  value_scratch.reserve(n);
  const auto block = static_cast<std::uint32_t>((n + groups_ - 1) / groups_);
  const std::size_t global = groups_ * work_items_;
  for (int shift = 0; shift < bits; shift += digit_bits_) {
    const auto s = static_cast<std::uint32_t>(shift);
    count_.launch(global, work_items_, keys, n, block, s, histogram_);
    scan.run(histogram_, static_cast<std::uint32_t>(histogram_.count()), false);
    scatter_.launch(global, work_items_, keys, values, n, block, s, histogram_, key_scratch, value_scratch);
    std::swap(keys, key_scratch);
    std::swap(values, value_scratch);
  }
}

}  // namespace simuli
