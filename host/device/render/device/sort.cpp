// Launcher of "kernels/sort.cl".
#include "host/device/render/device/sort.hpp"

#include <algorithm>
#include <utility>

#include "host/device/render/device/group_size.hpp"

namespace simuli {
namespace {

constexpr const char* kSortFile = "kernels/sort.cl";
constexpr std::size_t kLeastBlock = 1024;  // smaller blocks do not pay for a group's counters

/// Whether groups of one work-item suit the device; larger groups sort in local memory.
bool is_alone(const Device& device, std::size_t requested) {
  return requested == 0 ? device.info().is_cpu : requested == 1;
}
int digit_bits_of(bool alone) { return alone ? 11 : 8; }
std::size_t most_groups(const Device& device, bool alone) {
  return device.info().compute_units * (alone ? 2U : 4U);
}

std::size_t work_items_of(const Device& device, std::size_t requested) {
  if (requested != 0) return requested;
  if (is_alone(device, 0)) return 1;
  const BuildOptions options = BuildOptions().define("RADIX_BITS", digit_bits_of(false));
  return group_size_for(device, kSortFile, options, {"radix_count", "radix_scatter"}, 128);
}

Program program_of(const Device& device, std::size_t work_items, int digit_bits) {
  return {device, kSortFile, BuildOptions().define("LS", work_items).define("RADIX_BITS", digit_bits)};
}

}  // namespace

SortSizes SortStage::sizes(const Device& device, std::uint64_t pairs, std::size_t work_items) {
  const bool alone = is_alone(device, work_items);
  return {pairs,
          (std::uint64_t{1} << static_cast<unsigned>(digit_bits_of(alone))) * most_groups(device, alone)};
}

unsigned SortStage::passes(const Device& device, int bits, std::size_t work_items) {
  const int digit = digit_bits_of(is_alone(device, work_items));
  return static_cast<unsigned>((bits + digit - 1) / digit);
}

SortStage::SortStage(const Device& device, std::size_t work_items)
    : work_items_(work_items_of(device, work_items)),
      digit_bits_(digit_bits_of(work_items_ == 1)),
      scan_(device, work_items),
      buffers_(device),
      count_(program_of(device, work_items_, digit_bits_), "radix_count"),
      scatter_(program_of(device, work_items_, digit_bits_), "radix_scatter") {}

void SortStage::run(Buffer<std::uint32_t>& keys, Buffer<std::uint32_t>& values, std::uint32_t n, int bits) {
  if (n == 0) return;
  buffers_.reserve(sizes(buffers_.device(), n, work_items_));
  std::size_t groups = most_groups(buffers_.device(), work_items_ == 1);
  if (work_items_ > 1) groups = std::min(groups, (n + kLeastBlock - 1) / kLeastBlock);
  const auto block = static_cast<std::uint32_t>((n + groups - 1) / groups);
  const auto counters = static_cast<std::uint32_t>(groups << static_cast<unsigned>(digit_bits_));
  const std::size_t global = groups * work_items_;
  for (int bit = 0; bit < bits; bit += digit_bits_) {
    const auto shift = static_cast<std::uint32_t>(bit);
    count_.run(
        global,
        work_items_,
        {{"keys", keys}, {"n", n}, {"block", block}, {"shift", shift}, {"histogram", buffers_.histogram}});
    scan_.run(buffers_.histogram, counters, false);
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
