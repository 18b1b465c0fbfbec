#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

struct _cl_event;  // the object behind a cl_event

namespace simuli {

/// Device time of all launches of one kernel.
struct ProfileRow {
  std::string kernel;
  std::uint64_t count = 0;
  double total_ms = 0;
  double min_ms = 0;
};

/// Kernel times of one Device, from OpenCL events. It is disabled by default and then records nothing.
class Profile {
 public:
  explicit Profile(bool enabled) : enabled_(enabled) {}

  [[nodiscard]] bool enabled() const { return enabled_; }
  /// Returns the rows since the last reset(), most expensive first. Waits for the recorded launches.
  [[nodiscard]] std::vector<ProfileRow> rows();
  /// Discards all recorded launches.
  void reset();

  /// Records a launch; called by each launch when enabled(). Takes ownership of the event.
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
