#pragma once
// What Device and Program handles point to. Only host/device/runtime/*.cpp includes this.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/cl.hpp"
#include "host/device/runtime/declaration.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::detail {

/// Holds no Device: the Device's own table of programs refers to this.
struct ProgramState {
  ProgramState() = default;
  ProgramState(const ProgramState&) = delete;
  ProgramState& operator=(const ProgramState&) = delete;
  ~ProgramState() {
    if (Device::is_forked()) program() = nullptr;
  }

  std::string path;
  std::string options;
  Precision precision = Precision::kFloat;
  cl::Program program;
  std::vector<std::string> kernel_names;
  std::map<std::string, KernelDeclaration> declarations;  // of the text, by the kernel's name
};

struct DeviceState {
  DeviceState() = default;
  DeviceState(const DeviceState&) = delete;
  DeviceState& operator=(const DeviceState&) = delete;
  /// Frames that nobody waited for may still be rendered: a program that ends meanwhile takes the driver away
  /// from under its threads.
  ~DeviceState() {
    if (Device::is_forked()) {
      queue() = nullptr;
      context() = nullptr;
    } else if (queue() != nullptr) {
      clFinish(queue());
    }
  }

  DeviceInfo info;
  Quirks quirks;
  cl::Device device;
  cl::Context context;
  cl::CommandQueue queue;
  Profile profile{false};
  MemoryUse memory;
  std::map<std::string, MemoryUse> memory_by_name;
  // Programs built so far, by their full key (options and expanded source).
  std::map<std::string, std::shared_ptr<const ProgramState>> programs;
};

}  // namespace simuli::detail
