#pragma once
// For callers that use OpenCL directly: plain handles of the library's objects, and a Device on the caller's
// objects. No other header exposes OpenCL.
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/device.hpp"
#include "host/device/runtime/real_buffer.hpp"

namespace simuli::opencl {

// Handles are borrowed, not retained: they are valid during the lifetime of the Device or the Buffer.
[[nodiscard]] cl_context context(const Device& device);
[[nodiscard]] cl_command_queue queue(const Device& device);
[[nodiscard]] cl_device_id device_id(const Device& device);

/// Changes when the buffer's reserve() grows.
template <class T>
[[nodiscard]] cl_mem memory(const Buffer<T>& buffer) {
  return buffer.memory().handle();
}
[[nodiscard]] inline cl_mem memory(const RealBuffer& buffer) { return buffer.memory().handle(); }

// Device::adopt(cl_context, cl_command_queue) makes a Device of the caller's objects.

}  // namespace simuli::opencl
