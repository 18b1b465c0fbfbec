#ifndef SIMULI_OPENCL_H
#define SIMULI_OPENCL_H
/* For programs that use OpenCL themselves, in C and C++: a context and queue of theirs, and frames as device
 * memory. Needs <CL/cl.h>; nothing else of the library does. */
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include "host/apps/api/simuli.h"

/* A frame's results where they are: in slots, with the map between slots and rays. Borrowed: all of it lives as
 * long as the frame, and holds its values once `ready` is complete. `real` is float, or double when the frame was
 * rendered with render.precision=double. */
typedef struct simuli_frame_memory {
  cl_mem outputs;     /* real[6][slots]: three features, transmittance, sum of w tau (m), median distance (m); of
                       * LiDARs [7]: ln(p / (1 - p)), p the probability that the ray doesn't return */
  cl_mem picture;     /* real[3][slots] that replaces the features; NULL: colours are not graded */
  cl_mem ray_of_slot; /* int[slots]; -1: none */
  cl_mem slot_of_ray; /* int[rays]; -1: a pixel through which the lens sees nothing */
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

/* The other way is Device::adopt(context, queue). Borrowed: valid as long as the device. */
cl_context context(const Device& device);
cl_command_queue queue(const Device& device);
cl_device_id device_id(const Device& device);

simuli_frame_memory memory(const Frame& frame);

}  // namespace opencl
}  // namespace simuli

extern "C" {
#endif

/* Works on the caller's context and in-order queue, which are retained. */
simuli_status simuli_device_adopt(cl_context context, cl_command_queue queue, simuli_device** device);
/* Borrowed: valid as long as the device. */
simuli_status simuli_device_opencl(const simuli_device* device, cl_context* context, cl_command_queue* queue);
simuli_status simuli_frame_device_memory(const simuli_frame* frame, simuli_frame_memory* memory);

#ifdef __cplusplus
}
#endif
#endif
