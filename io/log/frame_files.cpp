#include "io/log/frame_files.hpp"

#include <algorithm>
#include <utility>

#include "host/core/base/interruption.hpp"
#include "io/log/sweep_file.hpp"

namespace simuli {
namespace {

// Frames to read ahead: one in use, one being read, and two that even out the reading times.
constexpr std::size_t kAhead = 4;

std::size_t bytes_of(const FrameFiles::Frame& frame) {
  if (const auto* const image = std::get_if<Image>(&frame)) return image->data.size() * sizeof(float);
  const auto& sweep = std::get<Sweep>(frame);
  return (sweep.range.size() + sweep.intensity.size() + sweep.rays.azimuth.size() +
          sweep.rays.elevation.size() + sweep.rays.time_fraction.size()) *
         sizeof(float);
}

}  // namespace

FrameFiles::FrameFiles(std::size_t budget_bytes) : kept_(budget_bytes) {}

FrameFiles::~FrameFiles() = default;

std::shared_ptr<const FrameFiles::Frame> FrameFiles::keep(const std::string& key, Frame frame) {
  return kept_.get(
      key, [&] { return std::move(frame); }, bytes_of);
}

std::shared_ptr<const FrameFiles::Frame> FrameFiles::get(const Wish& wish) {
  Interruption::ask();  // a whole drive may be read without a kernel in between
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return under_way_ != wish.key; });
  if (auto kept = kept_.find(wish.key)) return kept;
  if (auto found = ahead_.extract(wish.key)) {
    changed_.notify_all();
    return keep(wish.key, std::move(found.mapped()));
  }
  std::erase_if(wishes_, [&](const Wish& next) { return next.key == wish.key; });
  ++reads_;
  lock.unlock();
  Frame frame = wish.read();
  lock.lock();
  return keep(wish.key, std::move(frame));
}

void FrameFiles::expect(std::vector<Wish> wishes) {
  const std::lock_guard lock(mutex_);
  std::reverse(wishes.begin(), wishes.end());
  wishes_ = std::move(wishes);
  for (auto& [key, frame] : ahead_) keep(key, std::move(frame));  // get() finds them in kept_
  ahead_.clear();
  if (!wishes_.empty() && !reader_.joinable()) {
    reader_ = std::jthread([this](const std::stop_token& stop) { read_ahead(stop); });
  }
  changed_.notify_all();
}

void FrameFiles::read_ahead(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return !wishes_.empty() && ahead_.size() < kAhead; })) {
    const Wish wish = std::move(wishes_.back());
    wishes_.pop_back();
    if (ahead_.contains(wish.key) || kept_.find(wish.key)) continue;
    under_way_ = wish.key;
    lock.unlock();
    std::optional<Frame> frame;
    try {
      frame = wish.read();
    } catch (...) {  // get() reads it again and throws to its caller
    }
    lock.lock();
    under_way_.clear();
    if (frame) {
      ahead_.insert_or_assign(wish.key, std::move(*frame));
      ++reads_;
    }
    changed_.notify_all();
  }
}

std::size_t FrameFiles::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

std::size_t FrameFiles::kept_bytes() const {
  const std::lock_guard lock(mutex_);
  return kept_.used_bytes();
}

FrameFiles::Wish wish_of(const Log& log, const SweepFrame& frame) {
  std::filesystem::path file = log.folder / frame.file;
  return {file.string(), [file, shape = sweep_shape(log.lidar(frame.lidar).model)] {
            return read_recorded_sweep(file, shape);
          }};
}

Sweep read_sweep(const Log& log, const SweepFrame& frame, const LidarModel& lidar) {
  const std::filesystem::path file = log.folder / frame.file;
  if (log.files == nullptr) return read_sweep(file, lidar);
  return as_measured(std::get<Sweep>(*log.files->get(wish_of(log, frame))), file, lidar);
}

Sweep read_sweep(const Log& log, const SweepFrame& frame) {
  return read_sweep(log, frame, log.lidar(frame.lidar).model);
}

void expect(const Log& log, const std::vector<const SweepFrame*>& frames) {
  if (log.files == nullptr) return;
  std::vector<FrameFiles::Wish> wishes;
  for (const SweepFrame* frame : frames) wishes.push_back(wish_of(log, *frame));
  log.files->expect(std::move(wishes));
}

}  // namespace simuli
