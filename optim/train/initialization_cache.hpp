#pragma once
// Cache of initialisation results. The next training of the same log with other learning rates or another
// length starts at once.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/stopwatch.hpp"
#include "io/log/log.hpp"
#include "optim/base/packed.hpp"
#include "optim/train/train_report.hpp"

namespace simuli {

/// Files in cache_folder()/starts, up to kMost bytes for all logs; the least recently used are removed first.
/// The key of a result contains all inputs of its step in full: the build, the log with the bytes of its files,
/// and the step's options. Steps use no device. Safe for any number of processes.
class InitializationCache {
 public:
  static constexpr std::uintmax_t kMost = std::uintmax_t{2} << 30U;

  /// Does nothing when not `on`, without a cache folder, or when the linker gave the build no identifier.
  explicit InitializationCache(bool on);

  /// Returns make(options...), or its cached result. `value` supplies the parts that pack() does not store. A
  /// cache that cannot be written is no error.
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

  std::filesystem::path folder_;                          // empty: caching is off
  std::map<std::filesystem::path, std::uint64_t> files_;  // checksums of files already read
};

}  // namespace simuli
