#pragma once
// For callers who work with OpenCL themselves: the plain handles of what the library made, and a Device on
// what they made. Nobody else needs to know that there is OpenCL.
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/device.hpp"
#include "host/device/runtime/real_buffer.hpp"

namespace simuli::opencl {

// Borrowed, not retained: valid as long as the Device or the Buffer.
[[nodiscard]] cl_context context(const Device& device);
[[nodiscard]] cl_command_queue queue(const Device& device);
[[nodiscard]] cl_device_id device_id(const Device& device);

/// Changes when the buffer's reserve() grows.
template <class T>
[[nodiscard]] cl_mem memory(const Buffer<T>& buffer) {
  return buffer.memory().handle();
}
[[nodiscard]] inline cl_mem memory(const RealBuffer& buffer) { return buffer.memory().handle(); }

// The other way: Device::adopt(cl_context, cl_command_queue).

}  // namespace simuli::opencl
