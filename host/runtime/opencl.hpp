#pragma once
// The plain handles of what the library made, for those who work with OpenCL themselves.
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "host/runtime/buffer.hpp"
#include "host/runtime/device.hpp"
#include "host/runtime/real_buffer.hpp"

namespace simuli::opencl {

// Borrowed, not retained: valid as long as the Device or the Buffer.
[[nodiscard]] cl_context context(const Device& device);
[[nodiscard]] cl_command_queue queue(const Device& device);
[[nodiscard]] cl_device_id device_id(const Device& device);

/// Changes when the buffer's reserve() grows.
template <class T>
[[nodiscard]] cl_mem memory(const Buffer<T>& buffer) {
  return buffer.handle();
}
[[nodiscard]] inline cl_mem memory(const RealBuffer& buffer) { return buffer.memory().handle()(); }

}  // namespace simuli::opencl
