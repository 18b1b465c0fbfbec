#include "host/device/runtime/device.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <pthread.h>
#include <unistd.h>
#include <utility>

#include "host/core/base/split.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device_state.hpp"
#include "host/device/runtime/disk_cache.hpp"

namespace simuli {
namespace {

// 32 KiB is the minimum of OpenCL 1.2, and fits the first-level cache of CPUs.
constexpr std::uint64_t kCpuLocalBytes = 32U << 10U;

struct Found {
  cl::Device device;
  DeviceInfo info;
};

// Driver strings may end in spaces or a NUL.
std::string trimmed(std::string text) {
  const auto is_filler = [](char c) { return c == '\0' || std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_filler(text.back())) text.pop_back();
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), is_filler));
  return text;
}

bool has_word(const std::string& words, std::string_view word) {
  return (" " + words + " ").find(" " + std::string(word) + " ") != std::string::npos;
}

// "OpenCL 1.2 vendor text" -> at least 1.2. The standard fixes the form up to the second space.
bool at_least_1_2(const std::string& device_version) {
  int major = 0;
  int minor = 0;
  const std::string_view text(device_version);
  constexpr std::string_view kPrefix = "OpenCL ";
  if (!text.starts_with(kPrefix)) return false;
  const char* const end = text.data() + text.size();
  const auto after_major = std::from_chars(text.data() + kPrefix.size(), end, major);
  if (after_major.ec != std::errc() || after_major.ptr == end || *after_major.ptr != '.') return false;
  if (std::from_chars(after_major.ptr + 1, end, minor).ec != std::errc()) return false;
  return std::pair(major, minor) >= std::pair(1, 2);
}

/// Reads SIMULI_DEVICE_TYPE (cpu, gpu), which overrides the type of all devices, so that the code paths of GPUs
/// can run without one.
std::optional<cl_device_type> wanted_type() {
  const char* const variable = std::getenv("SIMULI_DEVICE_TYPE");
  if (variable == nullptr || *variable == '\0') return std::nullopt;
  const std::string_view text = variable;
  if (text == "gpu") return CL_DEVICE_TYPE_GPU;
  if (text == "cpu") return CL_DEVICE_TYPE_CPU;
  throw Error(ErrorKind::kUsage, fmt::format("SIMULI_DEVICE_TYPE: found '{}', allowed cpu, gpu", text));
}

DeviceInfo describe(const cl::Device& device) {
  // The platform's id or, with newer headers, the platform itself.
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  const cl_device_type type = wanted_type().value_or(device.getInfo<CL_DEVICE_TYPE>());
  DeviceInfo info;
  info.platform = trimmed(platform.getInfo<CL_PLATFORM_NAME>());
  info.platform_version = trimmed(platform.getInfo<CL_PLATFORM_VERSION>());
  info.name = trimmed(device.getInfo<CL_DEVICE_NAME>());
  info.vendor = trimmed(device.getInfo<CL_DEVICE_VENDOR>());
  info.device_version = trimmed(device.getInfo<CL_DEVICE_VERSION>());
  info.driver_version = trimmed(device.getInfo<CL_DRIVER_VERSION>());
  info.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  info.global_bytes = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
  info.max_alloc_bytes = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
  info.local_bytes = device.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>();
  info.max_work_group_size = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
  info.fp64 = has_word(trimmed(device.getInfo<CL_DEVICE_EXTENSIONS>()), "cl_khr_fp64") ||
              device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
  // Oclgrind reports every device type. It is used as a GPU, whose work-groups show the data races that it
  // searches for; it cannot run the explicit vectors of CPU shapes (llvm.vector.reduce).
  info.is_gpu = (type & CL_DEVICE_TYPE_GPU) != 0;
  info.is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0 && !info.is_gpu;
  info.usable = device.getInfo<CL_DEVICE_AVAILABLE>() != 0 &&
                device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() != 0 &&
                device.getInfo<CL_DEVICE_ENDIAN_LITTLE>() != 0 && at_least_1_2(info.device_version);
  return info;
}

Quirks quirks_of(const DeviceInfo& info) {
  Quirks quirks;
  const std::string platform = lower(info.platform);
  // Mesa's rusticl on a CPU aborts at prefetches of explicit vectors (its SPIR-V translation lacks
  // llvm.prefetch); GPU shapes run.
  quirks.prefers_explicit_vectors = info.is_cpu && platform.find("rusticl") == std::string::npos;
  quirks.compiles_at_first_launch = platform.find("portable computing language") != std::string::npos;
  const bool is_nvidia = platform.find("nvidia") != std::string::npos;
  quirks.binaries_lack_argument_info = is_nvidia;
  quirks.ignores_line_directives = is_nvidia || platform.find("oclgrind") != std::string::npos;
  quirks.usable_local_bytes = info.is_cpu ? std::min(info.local_bytes, kCpuLocalBytes) : info.local_bytes;
  return quirks;
}

int rank(const DeviceInfo& info) { return info.is_gpu ? 0 : (info.is_cpu ? 1 : 2); }

std::atomic<bool> is_used{false};
std::atomic<bool> is_lost{false};

/// Exits a forked child without running exit handlers: libraries would wait for ever for threads that do not
/// exist, and folders that the parent still uses would be removed. Files are flushed.
void lose_devices() {
  if (!is_used) return;
  is_lost = true;
#ifdef __GLIBC__
  const auto end = [](int status, void*) {
    static_cast<void>(std::fflush(nullptr));
    ::_exit(status);
  };
  static_cast<void>(::on_exit(end, nullptr));
#endif
}
const int watches_forks = ::pthread_atfork(nullptr, nullptr, lose_devices);

/// Serialises the first calls to drivers: they initialise themselves there, and not all of them lock.
std::vector<Found> find_all() {
  std::vector<Found> found;
  need_own_process();
  is_used = true;  // before the lock: a child forked meanwhile must not wait for the lock
  static std::mutex driver;
  const std::lock_guard lock(driver);
  prepare_driver_cache();
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error& error) {
    constexpr cl_int kNoPlatform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR: no driver is installed
    if (error.err() == kNoPlatform) return found;
    throw_cl_error(ErrorKind::kDevice, error, "listing the OpenCL platforms");
  }
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> devices;
    try {
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    } catch (const cl::Error& error) {
      if (error.err() == CL_DEVICE_NOT_FOUND) continue;
      throw_cl_error(ErrorKind::kDevice,
                     error,
                     "listing the devices of platform " + trimmed(platform.getInfo<CL_PLATFORM_NAME>()));
    }
    for (const cl::Device& device : devices) {
      cl_call(
          ErrorKind::kDevice,
          [] { return std::string("describing a device"); },
          [&] {
            found.push_back({device, describe(device)});
          });
    }
  }
  std::stable_sort(
      found.begin(), found.end(), [](const Found& a, const Found& b) { return rank(a.info) < rank(b.info); });
  return found;
}

std::string table(const std::vector<Found>& found) {
  if (found.empty())
    return "no OpenCL device at all (a driver is needed; PoCL runs on any CPU, given memory and a folder "
           "for its cache, which POCL_CACHE_DIR names)";
  std::string text = "the devices are:";
  for (std::size_t i = 0; i < found.size(); ++i) {
    text +=
        fmt::format(" [{}] {}{}", i, found[i].info.label(), found[i].info.usable ? "" : " (can't be used)");
  }
  return text;
}

std::optional<std::size_t> as_index(std::string_view text) {
  std::size_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [ptr, ec] = std::from_chars(text.data(), end, value);
  if (ec != std::errc() || ptr != end) return std::nullopt;
  return value;
}

const Found& choose(const std::vector<Found>& found, std::string_view request) {
  if (request.empty()) {
    const auto first =
        std::find_if(found.begin(), found.end(), [](const Found& entry) { return entry.info.usable; });
    if (first == found.end()) {
      throw Error(ErrorKind::kDevice, "no usable OpenCL device: " + table(found));
    }
    return *first;
  }
  const Found* match = nullptr;
  // A number beyond the list may be part of a name ("4090").
  if (const auto index = as_index(request); index && *index < found.size()) {
    match = &found[*index];
  } else {
    const auto named = std::find_if(found.begin(), found.end(), [&](const Found& entry) {
      return lower(entry.info.label()).find(lower(request)) != std::string::npos;
    });
    if (named != found.end()) match = &*named;
  }
  if (match == nullptr) {
    throw Error(ErrorKind::kDevice, fmt::format("no OpenCL device matches '{}': {}", request, table(found)));
  }
  if (!match->info.usable) {
    throw Error(ErrorKind::kDevice,
                fmt::format("device '{}' can't be used (needs to be available, OpenCL 1.2 or newer with a "
                            "compiler, little-endian): {}",
                            request,
                            table(found)));
  }
  return *match;
}

}  // namespace

std::vector<DeviceInfo> Device::list() {
  std::vector<DeviceInfo> infos;
  for (Found& entry : find_all()) infos.push_back(std::move(entry.info));
  return infos;
}

Device Device::best(std::string_view request, const DeviceOptions& options) {
  const char* const variable = std::getenv("SIMULI_DEVICE");
  if (request.empty() && variable != nullptr) request = variable;
  const std::vector<Found> all = find_all();
  const Found& chosen = choose(all, request);
  auto state = std::make_shared<detail::DeviceState>();
  state->info = chosen.info;
  state->quirks = quirks_of(chosen.info);
  state->device = chosen.device;
  state->profile = Profile(options.profiling);
  cl_call(
      ErrorKind::kDevice,
      [&] { return "opening " + chosen.info.label(); },
      [&] {
        state->context = cl::Context(chosen.device);
        const cl_command_queue_properties properties = options.profiling ? CL_QUEUE_PROFILING_ENABLE : 0;
        state->queue = cl::CommandQueue(state->context, chosen.device, properties);
      });
  return Device(std::move(state));
}

bool Device::is_forked() { return is_lost.load(std::memory_order_relaxed); }

void need_own_process() {
  if (!Device::is_forked()) return;
  throw Error(
      ErrorKind::kDevice,
      "device: found a process forked after devices were used, allowed one that is started anew (use the "
      "spawn start method) or forked before");
}

Device Device::adopt(cl_context context, cl_command_queue queue) {
  need_own_process();
  is_used = true;
  auto state = std::make_shared<detail::DeviceState>();
  cl_call(
      ErrorKind::kDevice,
      [] { return std::string("adopting the caller's context and queue"); },
      [&] {
        state->context = cl::Context(context, true);
        state->queue = cl::CommandQueue(queue, true);
        if (state->queue.getInfo<CL_QUEUE_CONTEXT>()() != context) {
          throw Error(ErrorKind::kDevice, "the caller's queue belongs to another context");
        }
        const auto properties = state->queue.getInfo<CL_QUEUE_PROPERTIES>();
        if ((properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) != 0) {
          throw Error(ErrorKind::kDevice, "the caller's queue is out of order, an in-order queue is needed");
        }
        state->profile = Profile((properties & CL_QUEUE_PROFILING_ENABLE) != 0);
        state->device = state->queue.getInfo<CL_QUEUE_DEVICE>();
        state->info = describe(state->device);
      });
  state->quirks = quirks_of(state->info);
  return Device(std::move(state));
}

const DeviceInfo& Device::info() const { return state_->info; }
const Quirks& Device::quirks() const { return state_->quirks; }
Profile& Device::profile() const { return state_->profile; }
const MemoryUse& Device::memory() const { return state_->memory; }
const std::map<std::string, MemoryUse>& Device::memory_by_name() const { return state_->memory_by_name; }

void Device::reset_memory_peak() const {
  state_->memory.peak = state_->memory.now;
  for (auto& [name, use] : state_->memory_by_name) use.peak = use.now;
}

void Device::finish() const {
  cl_call(
      ErrorKind::kDevice,
      [&] { return "waiting for " + state_->info.label(); },
      [&] { state_->queue.finish(); });
}

}  // namespace simuli
