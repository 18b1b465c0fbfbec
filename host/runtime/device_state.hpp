#pragma once
// What a Device handle points to. Only host/runtime/*.cpp includes this.
#include <map>
#include <memory>
#include <string>

#include "host/runtime/cl.hpp"
#include "host/runtime/device.hpp"

namespace simuli::detail {

struct ProgramState;

struct DeviceState {
  DeviceInfo info;
  Quirks quirks;
  cl::Device device;
  cl::Context context;
  cl::CommandQueue queue;
  Profile profile{false};
  MemoryUse memory;
  // Programs built so far, by their full key (options and expanded source).
  std::map<std::string, std::shared_ptr<const ProgramState>> programs;
};

}  // namespace simuli::detail
