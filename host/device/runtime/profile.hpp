#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

struct _cl_event;  // what a cl_event points to

namespace simuli {

/// Time on the device of all launches of one kernel.
struct ProfileRow {
  std::string kernel;
  std::uint64_t count = 0;
  double total_ms = 0;
  double min_ms = 0;
};

/// Kernel times of one Device, from OpenCL events. Disabled (the default) it keeps nothing.
class Profile {
 public:
  explicit Profile(bool enabled) : enabled_(enabled) {}

  [[nodiscard]] bool enabled() const { return enabled_; }
  /// Rows since the last reset(), most expensive first. Waits for the launches recorded so far.
  [[nodiscard]] std::vector<ProfileRow> rows();
  /// Forgets everything recorded so far.
  void reset();

  /// Called by each launch when enabled(). Takes the event over.
  void record(const std::string& kernel, _cl_event* event);

 private:
  struct ReleaseEvent {
    void operator()(_cl_event* event) const noexcept;
  };
  struct Pending {
    std::string kernel;
    std::unique_ptr<_cl_event, ReleaseEvent> event;
  };
  void collect();

  bool enabled_;
  std::vector<Pending> pending_;
  std::map<std::string, ProfileRow> rows_;
};

}  // namespace simuli
