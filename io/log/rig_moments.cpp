#include "io/log/rig_moments.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "host/core/base/spread.hpp"

namespace simuli {
namespace {

/// The frames of one camera or LiDAR.
struct SensorFrames {
  std::vector<double> times_s;              // middles of the frames, ascending
  std::vector<std::size_t> indices;         // of the frames in the log
  std::vector<std::size_t>* out = nullptr;  // receives the moments' numbers

  /// Median time between frames; 0 for a single frame.
  [[nodiscard]] double period_s() const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < times_s.size(); ++i) steps.push_back(times_s[i] - times_s[i - 1]);
    return upper_median(std::move(steps));
  }
};

template <class Frame, class Name>
void add_frames(const std::vector<Frame>& frames,
                const Name& name,
                std::vector<std::size_t>& out,
                std::vector<SensorFrames>& sensors) {
  out.resize(frames.size());
  std::map<std::string, std::vector<std::pair<double, std::size_t>>> by_name;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    by_name[name(frames[i])].emplace_back(0.5 * (frames[i].time_start_s + frames[i].time_end_s), i);
  }
  for (auto& [sensor, timed] : by_name) {
    std::stable_sort(timed.begin(), timed.end());
    SensorFrames& own = sensors.emplace_back();
    own.out = &out;
    for (const auto& [time_s, index] : timed) {
      own.times_s.push_back(time_s);
      own.indices.push_back(index);
    }
  }
}

/// Returns the index of the nearest time, of two equally near ones the earlier.
std::size_t nearest(const std::vector<double>& times_s, double time_s) {
  const auto after = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  if (after == times_s.begin()) return 0;
  const auto i = static_cast<std::size_t>(after - times_s.begin());
  return after == times_s.end() || time_s - times_s[i - 1] <= *after - time_s ? i - 1 : i;
}

/// Returns the delay of a sensor after the nearest moments in periods, -0.5 to 0.5. The mean is circular, because a
/// sensor that fires half a period after a moment is as near to the next one.
double phase(const SensorFrames& sensor, const std::vector<double>& moments_s, double period_s) {
  std::complex<double> sum = 0.0;
  for (const double time_s : sensor.times_s) {
    const double behind = (time_s - moments_s[nearest(moments_s, time_s)]) / period_s;
    sum += std::polar(1.0, 2.0 * std::numbers::pi * behind);
  }
  return std::arg(sum) / (2.0 * std::numbers::pi);
}

/// Returns the delay of each sensor after the start of its moments, in periods. A moment starts with the sensor that has
/// the first frame of all, and the others follow within a period; up to a tenth before it counts as simultaneous.
std::vector<double> delays(const std::vector<const SensorFrames*>& sensors,
                           const SensorFrames& lead,
                           double period_s) {
  const auto first =
      std::min_element(sensors.begin(), sensors.end(), [](const SensorFrames* a, const SensorFrames* b) {
        return a->times_s.front() < b->times_s.front();
      });
  const double begin = phase(**first, lead.times_s, period_s);
  std::vector<double> later;
  for (const SensorFrames* const sensor : sensors) {
    constexpr double kTogether = 0.1;
    const double behind = phase(*sensor, lead.times_s, period_s) - begin + kTogether;
    later.push_back(behind - std::floor(behind) - kTogether);
  }
  return later;
}

/// Numbers the frames of sensors with the same period; the first sensor has the most frames.
void number_together(const std::vector<const SensorFrames*>& sensors) {
  const double period_s = sensors.front()->period_s();
  std::vector<double> later(sensors.size());
  if (period_s > 0.0) later = delays(sensors, *sensors.front(), period_s);
  const auto moment_s = [&](std::size_t sensor, std::size_t frame) {
    return sensors[sensor]->times_s[frame] - later[sensor] * period_s;
  };
  std::vector<double> times_s;  // of moments
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    for (std::size_t i = 0; i < sensors[s]->times_s.size(); ++i) {
      const double time_s = moment_s(s, i);
      const bool is_known = s > 0 && std::abs(times_s[nearest(times_s, time_s)] - time_s) <= 0.5 * period_s;
      if (!is_known) times_s.insert(std::upper_bound(times_s.begin(), times_s.end(), time_s), time_s);
    }
  }
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    for (std::size_t i = 0; i < sensors[s]->indices.size(); ++i) {
      (*sensors[s]->out)[sensors[s]->indices[i]] = nearest(times_s, moment_s(s, i));
    }
  }
}

}  // namespace

RigMoments rig_moments(const Log& log) {
  RigMoments moments;
  std::vector<SensorFrames> sensors;  // LiDARs first: with equal numbers of frames a LiDAR leads
  add_frames(
      log.sweeps, [](const SweepFrame& f) { return f.lidar; }, moments.sweeps, sensors);
  add_frames(
      log.images, [](const ImageFrame& f) { return f.camera; }, moments.images, sensors);
  std::stable_sort(sensors.begin(), sensors.end(), [](const SensorFrames& a, const SensorFrames& b) {
    return a.times_s.size() > b.times_s.size();
  });
  std::vector<bool> is_done(sensors.size());
  for (std::size_t lead = 0; lead < sensors.size(); ++lead) {
    if (is_done[lead]) continue;
    const double period_s = sensors[lead].period_s();
    std::vector<const SensorFrames*> together;
    for (std::size_t i = lead; i < sensors.size(); ++i) {
      const double own_s = sensors[i].period_s();  // 0: a single frame fits any period
      if (is_done[i] || (i != lead && own_s > 0.0 && std::abs(own_s - period_s) > 0.25 * period_s)) continue;
      is_done[i] = true;
      together.push_back(&sensors[i]);
    }
    number_together(together);
  }
  return moments;
}

}  // namespace simuli
