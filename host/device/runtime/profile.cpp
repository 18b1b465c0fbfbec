#include "host/device/runtime/profile.hpp"

#include <algorithm>
#include <utility>

#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {
namespace {

// Events stored before their times are read: limits memory in long runs to one wait per so many launches.
constexpr std::size_t kMaxPending = 4096;
constexpr double kMsPerNs = 1e-6;

}  // namespace

void Profile::ReleaseEvent::operator()(_cl_event* event) const noexcept {
  if (!Device::is_forked()) clReleaseEvent(event);
}

void Profile::record(const std::string& kernel, _cl_event* event) {
  pending_.push_back({kernel, std::unique_ptr<_cl_event, ReleaseEvent>(event)});
  if (pending_.size() >= kMaxPending) collect();
}

void Profile::collect() {
  for (const Pending& pending : pending_) {
    cl_call(
        ErrorKind::kKernel,
        [&] { return "timing kernel " + pending.kernel; },
        [&] {
          const cl::Event event(pending.event.get(), true);
          event.wait();
          const cl_ulong start_ns = event.getProfilingInfo<CL_PROFILING_COMMAND_START>();
          const cl_ulong end_ns = event.getProfilingInfo<CL_PROFILING_COMMAND_END>();
          const double ms = kMsPerNs * static_cast<double>(end_ns - start_ns);
          ProfileRow& row = rows_[pending.kernel];
          row.kernel = pending.kernel;
          row.min_ms = row.count == 0 ? ms : std::min(row.min_ms, ms);
          row.total_ms += ms;
          ++row.count;
        });
  }
  pending_.clear();
}

std::vector<ProfileRow> Profile::rows() {
  collect();
  std::vector<ProfileRow> rows;
  rows.reserve(rows_.size());
  for (const auto& [name, row] : rows_) rows.push_back(row);
  std::stable_sort(rows.begin(), rows.end(), [](const ProfileRow& a, const ProfileRow& b) {
    return a.total_ms > b.total_ms;
  });
  return rows;
}

void Profile::reset() {
  pending_.clear();
  rows_.clear();
}

}  // namespace simuli
