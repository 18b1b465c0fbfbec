// Launcher of "kernels/scan.cl".
#include "host/render/frame/stages.hpp"

namespace simuli {
namespace {

std::size_t scan_work_items(const Device& device) {
  return device.info().is_cpu ? 1 : std::min<std::size_t>(256, device.info().max_work_group_size);
}

}  // namespace

ScanStage::ScanStage(const Device& device, std::size_t work_items)
    : work_items_(work_items == 0 ? scan_work_items(device) : work_items),
      scan_(Program(device, "kernels/scan.cl", BuildOptions().define("LS", work_items_)), "scan_exclusive"),
      total_(device, "scan total", 1) {}

std::uint64_t ScanStage::run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted) {
  scan_.launch(work_items_, work_items_, data, n, total_);
  return wanted ? total_.read_back() : 0;
}

}  // namespace simuli
