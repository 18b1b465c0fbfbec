#pragma once
// Khronos' C++ binding, set up in one place: OpenCL 1.2, exceptions on. Only sources of host/device/runtime include this header.
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS

#include <CL/opencl.hpp>
