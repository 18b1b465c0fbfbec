#include "io/scene/scene_clock.hpp"

#include <algorithm>
#include <cmath>

namespace simuli {
namespace {

constexpr double kMicroseconds = 1e6;

}  // namespace

std::string scene_id_of(std::filesystem::path path) {
  if (!path.has_filename()) path = path.parent_path();  // "drive.scene/"
  return path.stem().string();
}

SceneClock::SceneClock(const Trajectory& world_from_rig) {
  if (world_from_rig.poses().empty()) return;
  const double before_s = std::max(0.0, std::ceil(-world_from_rig.start_s()));
  start_us_ = -std::llround(before_s * kMicroseconds);
}

std::uint64_t SceneClock::microseconds(double time_s) const {
  return static_cast<std::uint64_t>(
      std::max<std::int64_t>(0, static_cast<std::int64_t>(std::llround(time_s * kMicroseconds)) - start_us_));
}

double SceneClock::seconds(std::uint64_t time_us) const {
  return static_cast<double>(static_cast<std::int64_t>(time_us) + start_us_) / kMicroseconds;
}

}  // namespace simuli
