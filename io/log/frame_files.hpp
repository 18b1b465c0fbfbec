#pragma once
// The frames of a log as their files decode: each is kept once read, and read ahead of its use by a thread.
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

/// Shared by a log and what was cut out of it. From any threads.
class FrameFiles {
 public:
  using Frame = std::variant<Image, Sweep>;
  /// What a file's frame is known by, and how it is read.
  struct Wish {
    std::string key;
    std::function<Frame()> read;
  };

  /// Keeps up to so many bytes, those asked for last, and a few more frames that were read ahead.
  explicit FrameFiles(std::size_t budget_bytes);
  ~FrameFiles();
  FrameFiles(const FrameFiles&) = delete;
  FrameFiles& operator=(const FrameFiles&) = delete;

  /// As wish.read() gives it, now or before. Its exceptions are the caller's.
  [[nodiscard]] std::shared_ptr<const Frame> get(const Wish& wish);
  /// These are asked for next, in this order: what is not kept is read meanwhile. Replaces what was expected
  /// before. A frame that can't be read is left to get().
  void expect(std::vector<Wish> wishes);

  /// Frames read so far.
  [[nodiscard]] std::size_t reads() const;
  [[nodiscard]] std::size_t kept_bytes() const;

 private:
  void read_ahead(const std::stop_token& stop);
  std::shared_ptr<const Frame> keep(const std::string& key, Frame frame);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  LruCache<Frame, std::string> kept_;
  std::vector<Wish> wishes_;            // the next one last
  std::map<std::string, Frame> ahead_;  // read and not asked for yet
  std::string under_way_;               // by the thread; empty: none
  std::size_t reads_ = 0;
  std::jthread reader_;  // from the first expect() on; ends before all else here
};

/// Log::files's, where there are any, for this log's frames; else each is read when it is asked for.
[[nodiscard]] Sweep read_sweep(const Log& log, const SweepFrame& frame, const LidarModel& lidar);
[[nodiscard]] Sweep read_sweep(const Log& log, const SweepFrame& frame);
[[nodiscard]] FrameFiles::Wish wish_of(const Log& log, const SweepFrame& frame);
/// Says that these are read next, in this order.
void expect(const Log& log, const std::vector<const SweepFrame*>& frames);

}  // namespace simuli
