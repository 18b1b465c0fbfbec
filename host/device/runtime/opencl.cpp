#include "host/device/runtime/opencl.hpp"

#include "host/device/runtime/device_state.hpp"

namespace simuli::opencl {

cl_context context(const Device& device) { return device.state().context(); }
cl_command_queue queue(const Device& device) { return device.state().queue(); }
cl_device_id device_id(const Device& device) { return device.state().device(); }

}  // namespace simuli::opencl
