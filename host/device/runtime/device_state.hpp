#pragma once
// The objects behind Device and Program handles. Only host/device/runtime/*.cpp includes this header.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/cl.hpp"
#include "host/device/runtime/declaration.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::detail {

/// Holds no Device, because the Device's table of programs refers to this object.
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
  std::map<std::string, KernelDeclaration> declarations;  // of the text's kernels, by name
};

struct DeviceState {
  DeviceState() = default;
  DeviceState(const DeviceState&) = delete;
  DeviceState& operator=(const DeviceState&) = delete;
  /// Waits for the queue: frames may still be rendering without a waiting caller, and a process that exits
  /// meanwhile would unload the driver while its threads run.
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
