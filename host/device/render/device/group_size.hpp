#pragma once
#include <cstddef>
#include <initializer_list>

#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Work-items a group, as many as `wanted` or half of that, a quarter, ...: the most with which the device
/// runs all of these kernels of a file when they are built with LS of that size. Error{kDevice} when it runs
/// none.
[[nodiscard]] std::size_t group_size_for(const Device& device,
                                         const char* file,
                                         const BuildOptions& options,
                                         std::initializer_list<const char*> kernels,
                                         std::size_t wanted);

}  // namespace simuli
