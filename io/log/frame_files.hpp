#pragma once
// A cache of decoded frames of a log, with a thread that reads them ahead of their use.
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/base/lru_cache.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Caches frames for a log and for the logs cut out of it. Thread-safe.
class FrameFiles {
 public:
  using Frame = std::variant<Image, Sweep>;
  /// A request for a frame: its key in the cache and the function that reads it.
  struct Wish {
    std::string key;
    std::function<Frame()> read;
  };

  /// Keeps the most recently requested frames, up to `budget_bytes`, and a few more that were read ahead.
  explicit FrameFiles(std::size_t budget_bytes);
  ~FrameFiles();
  FrameFiles(const FrameFiles&) = delete;
  FrameFiles& operator=(const FrameFiles&) = delete;

  /// Returns the frame that wish.read() returns, from the cache if possible. Passes on its exceptions.
  [[nodiscard]] std::shared_ptr<const Frame> get(const Wish& wish);
  /// Announces the next requests in their order, so that missing frames are read meanwhile. Replaces earlier
  /// announcements. Read errors are left to get().
  void expect(std::vector<Wish> wishes);

  /// Number of frames read so far.
  [[nodiscard]] std::size_t reads() const;
  [[nodiscard]] std::size_t kept_bytes() const;

 private:
  void read_ahead(const std::stop_token& stop);
  std::shared_ptr<const Frame> keep(const std::string& key, Frame frame);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  LruCache<Frame, std::string> kept_;
  std::vector<Wish> wishes_;            // the next request last
  std::map<std::string, Frame> ahead_;  // read, not requested yet
  std::string under_way_;               // key of the frame that the thread reads; empty: none
  std::size_t reads_ = 0;
  std::jthread reader_;  // started by expect(); joined before the other members are destroyed
};

/// Reads a sweep through the cache Log::files, or from its file if the log has no cache.
[[nodiscard]] Sweep read_sweep(const Log& log, const SweepFrame& frame, const LidarModel& lidar);
[[nodiscard]] Sweep read_sweep(const Log& log, const SweepFrame& frame);
[[nodiscard]] FrameFiles::Wish wish_of(const Log& log, const SweepFrame& frame);
/// Announces to the cache that these frames are read next, in this order.
void expect(const Log& log, const std::vector<const SweepFrame*>& frames);

}  // namespace simuli
