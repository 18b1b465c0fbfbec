// Launcher of "kernels/sort.cl".
#include "host/render/device/sort.hpp"

#include <utility>

namespace simuli {
namespace {

std::size_t work_items_of(const Device& device, std::size_t asked) {
  return asked != 0 ? asked : device.info().is_cpu ? 1 : 64;
}
int digit_bits_of(std::size_t work_items) { return work_items == 1 ? 11 : 4; }
std::size_t groups_of(const Device& device, std::size_t work_items) {
  return device.info().compute_units * (work_items == 1 ? 2U : 16U);
}

BuildOptions sort_options(std::size_t work_items, int digit_bits) {
  BuildOptions options;
  return options.define("LS", work_items).define("RADIX_BITS", digit_bits);
}

}  // namespace

SortSizes SortStage::sizes(const Device& device, std::uint64_t pairs, std::size_t work_items) {
  const std::size_t items = work_items_of(device, work_items);
  return {pairs,
          (std::uint64_t{1} << static_cast<unsigned>(digit_bits_of(items))) * groups_of(device, items)};
}

unsigned SortStage::passes(const Device& device, int bits, std::size_t work_items) {
  const int digit = digit_bits_of(work_items_of(device, work_items));
  return static_cast<unsigned>((bits + digit - 1) / digit);
}

SortStage::SortStage(const Device& device, std::size_t work_items)
    : work_items_(work_items_of(device, work_items)),
      digit_bits_(digit_bits_of(work_items_)),
      groups_(groups_of(device, work_items_)),
      scan_(device, work_items),
      buffers_(device),
      count_(Program(device, "kernels/sort.cl", sort_options(work_items_, digit_bits_)), "radix_count"),
      scatter_(Program(device, "kernels/sort.cl", sort_options(work_items_, digit_bits_)), "radix_scatter") {}

void SortStage::run(Buffer<std::uint32_t>& keys, Buffer<std::uint32_t>& values, std::uint32_t n, int bits) {
  if (n == 0) return;
  buffers_.reserve(sizes(buffers_.device(), n, work_items_));
  const auto block = static_cast<std::uint32_t>((n + groups_ - 1) / groups_);
  const std::size_t global = groups_ * work_items_;
  for (int bit = 0; bit < bits; bit += digit_bits_) {
    const auto shift = static_cast<std::uint32_t>(bit);
    count_.run(
        global,
        work_items_,
        {{"keys", keys}, {"n", n}, {"block", block}, {"shift", shift}, {"histogram", buffers_.histogram}});
    scan_.run(buffers_.histogram, static_cast<std::uint32_t>(buffers_.histogram.count()), false);
    scatter_.run(global,
                 work_items_,
                 {{"keys", keys},
                  {"values", values},
                  {"n", n},
                  {"block", block},
                  {"shift", shift},
                  {"base", buffers_.histogram},
                  {"keys_out", buffers_.keys},
                  {"values_out", buffers_.values}});
    keys.exchange(buffers_.keys);
    values.exchange(buffers_.values);
  }
}

}  // namespace simuli
