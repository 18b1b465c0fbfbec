#ifndef SIMULI_OPENCL_H
#define SIMULI_OPENCL_H
/* For C and C++ programs that use OpenCL: the program's own context and queue, and frames as device
 * memory. Only this header needs <CL/cl.h>. */
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "host/apps/api/simuli.h"

/* Results of a frame in device memory, in slots, with maps between slots and rays. Borrowed: valid as long as
 * the frame; the values are valid once `ready` is complete. `real` is float, or double if the frame was
 * rendered with render.precision=double. */
typedef struct simuli_frame_memory {
  cl_mem outputs;     /* real[6][slots]: three features, transmittance, sum of w tau (m), median distance
                       * (m); LiDARs [7]: ln(p / (1 - p)), p the probability of ray drop */
  cl_mem picture;     /* real[3][slots], replaces the features; NULL: no bilateral grid was applied */
  cl_mem ray_of_slot; /* int[slots]; -1: none */
  cl_mem slot_of_ray; /* int[rays]; -1: a pixel without a ray */
  cl_event ready;
  size_t slots;
  size_t rays;
  int is_double;
} simuli_frame_memory;

#ifdef __cplusplus
namespace simuli {
class Device;
class Frame;
namespace opencl {

/* Inverse of Device::adopt(context, queue). Borrowed: valid as long as the device. */
cl_context context(const Device& device);
cl_command_queue queue(const Device& device);
cl_device_id device_id(const Device& device);

simuli_frame_memory memory(const Frame& frame);

}  // namespace opencl
}  // namespace simuli

extern "C" {
#endif

/* Uses the caller's context and in-order queue, which are retained. */
simuli_status simuli_device_adopt(cl_context context, cl_command_queue queue, simuli_device** device);
/* Borrowed: valid as long as the device. */
simuli_status simuli_device_opencl(const simuli_device* device, cl_context* context, cl_command_queue* queue);
simuli_status simuli_frame_device_memory(const simuli_frame* frame, simuli_frame_memory* memory);

#ifdef __cplusplus
}
#endif
#endif
