#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/runtime/profile.hpp"

// What cl_context and cl_command_queue point to (host/device/runtime/opencl.hpp).
struct _cl_context;
struct _cl_command_queue;

namespace simuli {

/// What a device says of itself.
struct DeviceInfo {
  std::string platform, platform_version;
  std::string name, vendor, device_version, driver_version;
  std::uint32_t compute_units = 0;
  std::uint64_t global_bytes = 0;
  std::uint64_t max_alloc_bytes = 0;  // CL_DEVICE_MAX_MEM_ALLOC_SIZE: no Buffer is larger
  std::uint64_t local_bytes = 0;
  std::size_t max_work_group_size = 0;
  bool fp64 = false;    // double precision: needed by Precision::kDouble
  bool is_cpu = false;  // the device is the host's own processor
  bool is_gpu = false;
  bool usable = false;  // available, has a compiler, little-endian, OpenCL 1.2 or newer

  /// "platform / name": what a device request is searched in.
  [[nodiscard]] std::string label() const { return platform + " / " + name; }
};

/// Known oddities of drivers, each named once, with its reason. Nothing else asks for a vendor's name.
struct Quirks {
  /// CPU drivers (PoCL) don't vectorise a work-item that has a loop: kernels use explicit vectors there.
  bool prefers_explicit_vectors = false;
  /// PoCL generates code at the first launch of each local size: warm up before timing.
  bool compiles_at_first_launch = false;
  /// Programs loaded from a stored binary may lack argument info (NVIDIA): types are then checked only
  /// after a build from source.
  bool binaries_lack_argument_info = false;
  /// Oclgrind and NVIDIA number lines of the expanded text: their build logs name no file of cl/.
  bool ignores_line_directives = false;
  /// Local memory to plan for. CPU drivers report the cache (1 MiB and more), which spills.
  std::uint64_t usable_local_bytes = 0;
};

struct DeviceOptions {
  bool profiling = false;  // record the time of every kernel in Device::profile()
};

namespace detail {
struct DeviceState;
}

/// Bytes of the Buffers on a device: now, and the most there ever were at once.
struct MemoryUse {
  std::uint64_t now = 0;
  std::uint64_t peak = 0;
};

/// One OpenCL device with its context and in-order queue. A handle: copies refer to the same device,
/// and Buffers, Programs and Kernels keep it alive. A Device and what was made on it are used by one
/// thread at a time.
class Device {
 public:
  /// All devices of all platforms: GPUs first, then CPUs, then the rest; the order of the drivers
  /// within. Empty when there is no driver at all.
  [[nodiscard]] static std::vector<DeviceInfo> list();

  /// Opens a device. `request` is an index into list() or a part of "platform / device" (case is
  /// ignored, the first in list() order wins); empty: the environment variable SIMULI_DEVICE; empty
  /// too: the first usable device. Error{kDevice} listing the devices when nothing matches or the
  /// device asked for can't be used: never silently another one.
  [[nodiscard]] static Device best(std::string_view request = {}, const DeviceOptions& options = {});

  /// Whether this process is a fork() of one that had used devices. The threads of its driver are not there, so
  /// that whatever needs a device throws Error{kDevice}, and what was made on one is left where it is.
  [[nodiscard]] static bool is_forked();

  /// Works on a caller's own context and in-order queue (both are retained). Error{kDevice} for an
  /// out-of-order queue or a queue of another context.
  [[nodiscard]] static Device adopt(_cl_context* context, _cl_command_queue* queue);

  [[nodiscard]] const DeviceInfo& info() const;
  [[nodiscard]] const Quirks& quirks() const;
  [[nodiscard]] Profile& profile() const;
  [[nodiscard]] const MemoryUse& memory() const;
  /// The same by the buffers' names; buffers of one name count together.
  [[nodiscard]] const std::map<std::string, MemoryUse>& memory_by_name() const;
  /// Makes the peaks what is used now.
  void reset_memory_peak() const;

  /// Waits until everything queued so far has run. Error{kDevice} when some of it failed.
  void finish() const;

  [[nodiscard]] detail::DeviceState& state() const { return *state_; }

 private:
  explicit Device(std::shared_ptr<detail::DeviceState> state) : state_(std::move(state)) {}
  std::shared_ptr<detail::DeviceState> state_;
};

}  // namespace simuli
