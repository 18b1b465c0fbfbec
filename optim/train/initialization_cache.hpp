#pragma once
// What the steps of a training's start come to, kept for the next training of the same log: one with other
// rates or another length starts at once.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/stopwatch.hpp"
#include "io/log/log.hpp"
#include "optim/base/packed.hpp"
#include "optim/train/initialization_report.hpp"

namespace simuli {

/// Files in cache_folder()/starts, up to kMost bytes of all logs: what was asked for longest ago goes. A step's
/// is found by all that it reads, in full: the build, the log as the step gets it with its files' bytes, and
/// the step's options. Steps use no device. From any number of processes.
class InitializationCache {
 public:
  static constexpr std::uintmax_t kMost = std::uintmax_t{2} << 30U;

  /// Keeps nothing when not `on`, without a cache folder, or where the linker has given the build no number.
  explicit InitializationCache(bool on);

  /// make(options...), or what that came to before, in `value`: which holds of the result what pack() does not.
  /// A cache that can't be written is no error.
  template <class Value, class Make, class... Options>
  Value get(InitializationReport& report,
            const std::string& step,
            const Log& log,
            Value value,
            const Make& make,
            Options... options) {
    if (folder_.empty()) return make(options...);
    Packed key = key_of(step, log);
    key(options...);
    const Stopwatch watch;
    double seconds = 0.0;
    if (std::optional<Packed> kept = find(key, report)) {
      (*kept)(seconds, value);
      report.saved_s += seconds;
      if constexpr (requires { value.report.seconds; }) value.report.seconds = watch.seconds();
      return value;
    }
    value = make(options...);
    seconds = watch.seconds();
    Packed made;
    made(seconds, value);
    keep(key, made);
    return value;
  }

 private:
  [[nodiscard]] Packed key_of(std::string step, const Log& log);
  [[nodiscard]] std::filesystem::path file_of(const Packed& key) const;
  [[nodiscard]] std::optional<Packed> find(const Packed& key, InitializationReport& report) const;
  void keep(const Packed& key, const Packed& value) const;

  std::filesystem::path folder_;                          // empty: nothing is kept
  std::map<std::filesystem::path, std::uint64_t> files_;  // checksums of those that were read
};

}  // namespace simuli
