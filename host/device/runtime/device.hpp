#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/runtime/profile.hpp"

// The objects behind cl_context and cl_command_queue (host/device/runtime/opencl.hpp).
struct _cl_context;
struct _cl_command_queue;

namespace simuli {

/// Properties that the driver reports for a device.
struct DeviceInfo {
  std::string platform, platform_version;
  std::string name, vendor, device_version, driver_version;
  std::uint32_t compute_units = 0;
  std::uint64_t global_bytes = 0;
  std::uint64_t max_alloc_bytes = 0;  // CL_DEVICE_MAX_MEM_ALLOC_SIZE, the largest size of a Buffer
  std::uint64_t local_bytes = 0;
  std::size_t max_work_group_size = 0;
  bool fp64 = false;    // double precision: needed by Precision::kDouble
  bool is_cpu = false;  // the device is the host's own processor
  bool is_gpu = false;
  bool usable = false;  // available, has a compiler, little-endian, OpenCL 1.2 or newer

  /// Returns "platform / name", the text that device requests are matched with.
  [[nodiscard]] std::string label() const { return platform + " / " + name; }
};

/// Known driver quirks, each with its reason. No other code tests for a vendor's name.
struct Quirks {
  /// CPU drivers (PoCL) do not vectorise work-items that contain loops: kernels use explicit vectors there.
  bool prefers_explicit_vectors = false;
  /// PoCL generates code at the first launch of each local size: warm up before timing.
  bool compiles_at_first_launch = false;
  /// Programs loaded from a stored binary may lack argument info (NVIDIA): types are then checked only
  /// after a build from source.
  bool binaries_lack_argument_info = false;
  /// Oclgrind and NVIDIA number lines of the expanded text: their build logs name no file of cl/.
  bool ignores_line_directives = false;
  /// Local memory in bytes that kernels may use. CPU drivers report the size of a cache (1 MiB and more), which
  /// spills.
  std::uint64_t usable_local_bytes = 0;
};

struct DeviceOptions {
  bool profiling = false;  // record the time of every kernel in Device::profile()
};

namespace detail {
struct DeviceState;
}

/// Bytes of all Buffers on a device: current and peak.
struct MemoryUse {
  std::uint64_t now = 0;
  std::uint64_t peak = 0;
};

/// One OpenCL device with its context and in-order queue. A handle: copies refer to the same device,
/// and Buffers, Programs and Kernels keep it alive. A Device and its objects may be used by one
/// thread at a time.
class Device {
 public:
  /// Returns all devices of all platforms: GPUs, then CPUs, then others, each in the drivers' order. Empty
  /// without any driver.
  [[nodiscard]] static std::vector<DeviceInfo> list();

  /// Opens a device. `request` is an index into list() or a part of "platform / device" (case is
  /// ignored, the first in list() order wins); empty: the environment variable SIMULI_DEVICE; empty
  /// too: the first usable device. Throws Error{kDevice} with the list of devices when none
  /// matches or the requested device is unusable; it never opens another device instead.
  [[nodiscard]] static Device best(std::string_view request = {}, const DeviceOptions& options = {});

  /// Whether this process was forked from a process that used a device. The driver's threads do not exist here:
  /// every call that needs a device throws Error{kDevice}, and destructors release nothing.
  [[nodiscard]] static bool is_forked();

  /// Uses a caller's context and in-order queue, and retains both. Throws Error{kDevice} for an out-of-order
  /// queue or a queue of another context.
  [[nodiscard]] static Device adopt(_cl_context* context, _cl_command_queue* queue);

  [[nodiscard]] const DeviceInfo& info() const;
  [[nodiscard]] const Quirks& quirks() const;
  [[nodiscard]] Profile& profile() const;
  [[nodiscard]] const MemoryUse& memory() const;
  /// Memory use by buffer name; buffers of the same name are summed.
  [[nodiscard]] const std::map<std::string, MemoryUse>& memory_by_name() const;
  /// Resets the peaks to the current use.
  void reset_memory_peak() const;

  /// Waits until all queued work has finished. Throws Error{kDevice} when any of it failed.
  void finish() const;

  [[nodiscard]] detail::DeviceState& state() const { return *state_; }

 private:
  explicit Device(std::shared_ptr<detail::DeviceState> state) : state_(std::move(state)) {}
  std::shared_ptr<detail::DeviceState> state_;
};

}  // namespace simuli
