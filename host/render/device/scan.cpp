// Launcher of "kernels/scan.cl".
#include "host/render/device/scan.hpp"

#include <algorithm>

namespace simuli {
namespace {

std::size_t scan_work_items(const Device& device) {
  return device.info().is_cpu ? 1 : std::min<std::size_t>(256, device.info().max_work_group_size);
}

}  // namespace

Chunks chunks_of(const Device& device, std::size_t n) {
  const std::size_t target = device.info().compute_units * (device.info().is_cpu ? 4U : 256U);
  const std::size_t chunk = std::max<std::size_t>(16, (n + target - 1) / target);
  return {(n + chunk - 1) / chunk, static_cast<std::uint32_t>(chunk)};
}

ScanStage::ScanStage(const Device& device, std::size_t work_items)
    : work_items_(work_items == 0 ? scan_work_items(device) : work_items),
      scan_(Program(device, "kernels/scan.cl", BuildOptions().define("LS", work_items_)), "scan_exclusive"),
      buffers_(device) {
  buffers_.reserve({});
}

std::uint64_t ScanStage::run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted) {
  scan_.run(work_items_, work_items_, {{"data", data}, {"n", n}, {"total", buffers_.total}});
  return wanted ? buffers_.total.read_back() : 0;
}

}  // namespace simuli
