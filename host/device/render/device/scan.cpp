// Launcher of "kernels/scan.cl".
#include "host/device/render/device/scan.hpp"

#include <algorithm>
#include <vector>

#include "host/device/render/device/group_size.hpp"

namespace simuli {
namespace {

constexpr const char* kScanFile = "kernels/scan.cl";
constexpr std::size_t kOwn = 8;  // elements of each work-item in groups of several

std::size_t scan_work_items(const Device& device) {
  if (device.info().is_cpu) return 1;
  return group_size_for(device, kScanFile, {}, {"scan_sums", "scan_exclusive"}, 256);
}

Program program_of(const Device& device, std::size_t work_items) {
  return {device, kScanFile, BuildOptions().define("LS", work_items)};
}

}  // namespace

Chunks chunks_of(const Device& device, std::size_t n, std::size_t group) {
  if (group == 0) group = device.info().is_cpu ? 1 : 64;
  const std::size_t target = device.info().compute_units * (group == 1 ? 4U : 256U);
  const std::size_t chunk = std::max<std::size_t>(group == 1 ? 16 : 4, (n + target - 1) / target);
  return {round_up((n + chunk - 1) / chunk, group), group, static_cast<std::uint32_t>(chunk)};
}

ScanStage::ScanStage(const Device& device, std::size_t work_items)
    : work_items_(work_items == 0 ? scan_work_items(device) : work_items),
      sums_(program_of(device, work_items_), "scan_sums"),
      scan_(program_of(device, work_items_), "scan_exclusive"),
      buffers_(device) {}

void ScanStage::launch(Buffer<std::uint32_t>& data, std::uint32_t n, std::uint32_t middle) {
  const auto block = static_cast<std::uint32_t>(work_items_ == 1 ? n : kOwn * work_items_);
  const std::size_t groups = sizes(buffers_.device(), n, work_items_).groups;
  buffers_.reserve({groups});
  const Binding blocks{"block", block};
  const std::size_t all = groups * work_items_;
  if (groups > 1) sums_.run(all, work_items_, {{"data", data}, {"n", n}, blocks, {"sums", buffers_.sums}});
  scan_.run(all,
            work_items_,
            {{"data", data},
             {"n", n},
             blocks,
             {"middle", middle},
             {"sums", buffers_.sums},
             {"total", buffers_.total}});
}

ScanSizes ScanStage::sizes(const Device& device, std::uint64_t n, std::size_t work_items) {
  if (work_items == 0) work_items = scan_work_items(device);
  const std::size_t block = kOwn * work_items;
  return {work_items == 1 ? 1 : std::max<std::uint64_t>(1, (n + block - 1) / block)};
}

std::uint64_t ScanStage::run(Buffer<std::uint32_t>& data, std::uint32_t n, bool wanted) {
  launch(data, n, n);
  return wanted ? buffers_.total.download().front() : 0;
}

std::pair<std::uint32_t, std::uint64_t> ScanStage::run_two(Buffer<std::uint32_t>& data, std::uint32_t n) {
  launch(data, 2 * n, n);
  const std::vector<std::uint64_t> totals = buffers_.total.download();
  const std::uint64_t first = n == 0 ? 0 : totals[1];
  return {static_cast<std::uint32_t>(first), totals[0] - first};
}

}  // namespace simuli
