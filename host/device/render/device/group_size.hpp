#pragma once
#include <cstddef>
#include <initializer_list>

#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Returns the number of work-items per group: the largest of `wanted`, wanted / 2, wanted / 4, ... for which
/// the device can run all these kernels of a file, built with LS of that size. Throws Error{kDevice} when there
/// is none.
[[nodiscard]] std::size_t group_size_for(const Device& device,
                                         const char* file,
                                         const BuildOptions& options,
                                         std::initializer_list<const char*> kernels,
                                         std::size_t wanted);

}  // namespace simuli
