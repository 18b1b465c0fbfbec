// C API of devices, and the OpenCL interface of C and C++.
#include "host/apps/api/c_handles.hpp"
#include "host/apps/api/opencl.h"
#include "host/core/base/version.hpp"
#include "host/device/render/scene/frame_state.hpp"
#include "host/device/runtime/opencl.hpp"

namespace simuli::opencl {

simuli_frame_memory memory(const Frame& frame) {
  const FrameBuffersOfRays b = FrameAccess::buffers(frame);
  return {memory(b.outputs),
          b.picture == nullptr ? nullptr : memory(*b.picture),
          memory(b.ray_of_slot),
          memory(b.slot_of_ray),
          FrameAccess::ready(frame),
          b.slots,
          b.rays,
          b.outputs.precision() == Precision::kDouble ? 1 : 0};
}

}  // namespace simuli::opencl

using namespace simuli;
using namespace simuli::capi;

extern "C" {

const char* simuli_version(void) { return version(); }

const char* simuli_error(void) { return last_error().c_str(); }

simuli_status simuli_device_open(const char* request, simuli_device** device) {
  return guarded([&] {
    simuli_device*& out = need(device, "device");
    Device opened = Device::best(text(request));
    std::string name = opened.info().label();
    out = new simuli_device{std::move(opened), std::move(name)};
  });
}

simuli_status simuli_device_adopt(cl_context context, cl_command_queue queue, simuli_device** device) {
  return guarded([&] {
    simuli_device*& out = need(device, "device");
    Device adopted = Device::adopt(&need(context, "context"), &need(queue, "queue"));
    std::string name = adopted.info().label();
    out = new simuli_device{std::move(adopted), std::move(name)};
  });
}

const char* simuli_device_name(const simuli_device* device) {
  return device == nullptr ? "" : device->name.c_str();
}

void simuli_device_close(simuli_device* device) { delete device; }

simuli_status simuli_device_opencl(const simuli_device* device,
                                   cl_context* context,
                                   cl_command_queue* queue) {
  return guarded([&] {
    const Device& of = need(device, "device").device;
    need(context, "context") = opencl::context(of);
    need(queue, "queue") = opencl::queue(of);
  });
}

simuli_status simuli_frame_device_memory(const simuli_frame* frame, simuli_frame_memory* memory) {
  return guarded([&] { need(memory, "memory") = opencl::memory(need(frame, "frame").frame); });
}

}  // extern "C"
