#include "host/device/render/device/group_size.hpp"

#include <algorithm>

#include "host/device/runtime/kernel.hpp"

namespace simuli {

std::size_t group_size_for(const Device& device,
                           const char* file,
                           const BuildOptions& options,
                           std::initializer_list<const char*> kernels,
                           std::size_t wanted) {
  std::size_t size = std::min(wanted, device.info().max_work_group_size);
  const auto runs = [&](const char* kernel) {
    return Kernel(Program(device, file, BuildOptions(options).define("LS", size)), kernel).max_local_size() >=
           size;
  };
  // Register use may limit groups to less than the device's maximum.
  while (size > 1 && !std::all_of(kernels.begin(), kernels.end(), runs)) size /= 2;
  return size;
}

}  // namespace simuli
