#include "bench/trade/trade.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "bench/render/stages.hpp"
#include "bench/trade/trade_views.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/scene/scene_on_device.hpp"

namespace simuli::bench {
namespace {

struct Candidate {
  std::string name;
  RenderOptions options;
  bool is_quality = false;
};

/// Returns candidates with one changed option each.
std::vector<Candidate> single_options(bool moves) {
  std::vector<Candidate> all;
  const auto add = [&all](const std::string& key, const std::vector<std::string>& values) {
    for (const std::string& value : values) {
      RenderOptions o;
      // Without these options the values have no effect.
      if (key == "projection") o.extent = Extent::kUnscented;
      if (key == "window") o.order = Order::kWindow;
      fields_of(o).apply({fmt::format("render.{}={}", key, value)});
      all.push_back({fmt::format("{}={}", key, value), o, false});
    }
  };
  add("extent", {"unscented"});
  add("projection", {"linearized", "monte_carlo"});
  add("order", {"per_ray"});
  add("window", {"8", "16", "32"});
  add("sh_direction", {"ray"});
  add("sh_degree", {"0", "1", "2"});
  add("sh_storage", {"half"});
  add("alpha_cut", {"0.1", "0.05", "0.02", "0.001", "0.0001"});
  add("transmittance_cut", {"0.1", "0.03", "0.01", "0.001", "1e-06"});
  if (moves) add("shutter_iterations", {"0", "1", "2", "8"});
  add("detail", {"0.25", "0.5", "1", "2"});
  add("precision", {"double"});
  return all;
}

/// Returns the given options or all single options, then the qualities.
std::vector<Candidate> candidates(const TradeOptions& options, bool moves) {
  std::vector<Candidate> all;
  if (options.own_name.empty()) {
    all = single_options(moves);
  } else {
    all.push_back({options.own_name, options.own, false});
  }
  for (const Quality quality : {Quality::kDraft, Quality::kBalanced, Quality::kExact, Quality::kReference}) {
    all.push_back({quality_names()[static_cast<std::size_t>(quality)], options_of(quality), true});
  }
  return all;
}

/// One set of options for a sensor's views, with its device data.
class Way {
 public:
  Way(const Device& device, const TradeScene& scene, const TradeSensor& sensor, const RenderOptions& options)
      : sensor_(sensor), scene_(device, borrowed(scene.scene), options) {}

  Frame render(std::size_t view) {
    return scene_.render(sensor_.views[view].sensor, sensor_.views[view].shot);
  }
  RayResults results(std::size_t view) { return render(view).results(); }
  /// Returns the frame time and adds device times by stage.
  double frame_ms(std::size_t view, std::map<std::string, double>& stage_ms) {
    Profile& profile = scene_.device().profile();
    profile.reset();
    const double ms = time_ms([&] { render(view).wait(); });
    for (const auto& [stage, time] : stage_times(profile)) stage_ms[stage] += time;
    return ms;
  }

 private:
  const TradeSensor& sensor_;
  SceneOnDevice scene_;
};

double in_picture(float value) { return std::clamp(static_cast<double>(value), 0.0, 1.0); }

void compare_pictures(const std::vector<RayResults>& found,
                      const std::vector<RayResults>& truth,
                      TradePoint& point) {
  double square = 0.0, count = 0.0;
  for (std::size_t view = 0; view < truth.size(); ++view) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < truth[view].rays; ++i) {
        const double error =
            std::abs(in_picture(found[view].feature[c][i]) - in_picture(truth[view].feature[c][i]));
        square += error * error;
        point.worst = std::max(point.worst, error);
        count += 1.0;
      }
    }
  }
  point.error = std::sqrt(square / count);
  point.psnr_db = -20.0 * std::log10(point.error);
}

void compare_sweeps(const std::vector<RayResults>& found,
                    const std::vector<RayResults>& truth,
                    TradePoint& point) {
  const auto returns = [](const RayResults& r, std::size_t i) {
    return r.drop_probability(i) <= 0.5F && best_distance(r, i) > 0.0F;
  };
  std::vector<double> errors;
  double changed = 0.0, count = 0.0, sum = 0.0;
  for (std::size_t view = 0; view < truth.size(); ++view) {
    for (std::size_t i = 0; i < truth[view].rays; ++i) {
      const bool here = returns(found[view], i), there = returns(truth[view], i);
      changed += here != there ? 1.0 : 0.0;
      count += 1.0;
      if (!here || !there) continue;
      errors.push_back(std::abs(static_cast<double>(best_distance(found[view], i)) -
                                static_cast<double>(best_distance(truth[view], i))));
      sum += errors.back();
    }
  }
  point.changed_share = changed / count;
  if (errors.empty()) return;
  const auto at = [&errors](double share) {
    const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(errors.size() - 1));
    std::nth_element(errors.begin(), errors.begin() + place, errors.end());
    return errors[static_cast<std::size_t>(place)];
  };
  point.error = sum / static_cast<double>(errors.size());
  point.median_m = at(0.5);
  point.p99_m = at(0.99);
}

/// Times a candidate and balanced in turns.
void time_both(Way& way, Way& balanced, std::size_t views, int repeats, TradePoint& point) {
  constexpr double kEnough_ms = 2000.0;  // slow candidates are repeated less often
  constexpr int kLeast = 3;
  std::vector<double> ms, ratios;
  std::map<std::string, double> stages, ignored;
  double spent_ms = 0.0;
  for (int i = -1; i < repeats; ++i) {
    double one = 0.0, other = 0.0;
    for (std::size_t view = 0; view < views; ++view) {
      one += way.frame_ms(view, stages);
      other += balanced.frame_ms(view, ignored);
    }
    if (i < 0) {  // the first launches compile
      stages.clear();
      continue;
    }
    ms.push_back(one / static_cast<double>(views));
    ratios.push_back(one / other);
    spent_ms += one;
    if (i + 1 >= kLeast && spent_ms > kEnough_ms) break;
  }
  for (const auto& [stage, total_ms] : stages) {
    point.stage_ms[stage] = total_ms / static_cast<double>(views * ms.size());
  }
  point.frame_ms = spread_of(ms);
  point.times_balanced = spread_of(ratios);
}

std::vector<RayResults> all_results(Way& way, std::size_t views) {
  std::vector<RayResults> results;
  for (std::size_t view = 0; view < views; ++view) results.push_back(way.results(view));
  return results;
}

bool moves(const TradeSensor& sensor) {
  return std::any_of(sensor.views.begin(), sensor.views.end(), [](const TradeView& v) {
    return (v.shot.world_from_sensor_end.translation - v.shot.world_from_sensor_start.translation).norm() >
           0.0;
  });
}

}  // namespace

void mark_front(std::vector<TradePoint>& points) {
  constexpr double kAlike = 1.03;  // ratio up to which times and errors count as equal
  const std::string& reference = quality_names().back();
  for (TradePoint& p : points) {
    p.on_front = std::none_of(points.begin(), points.end(), [&](const TradePoint& q) {
      if (&p == &q || p.variant == reference || q.variant == reference || p.sensor != q.sensor) return false;
      const double p_ms = p.times_balanced.median, q_ms = q.times_balanced.median;
      return (q_ms * kAlike < p_ms && q.error <= p.error) || (q_ms <= p_ms && q.error * kAlike < p.error);
    });
  }
}

std::vector<TradePoint> run_trade(const std::string& device_request,
                                  const TradeOptions& options,
                                  const Note& note) {
  DeviceOptions device_options;
  device_options.profiling = true;
  const Device device = Device::best(device_request, device_options);
  if (!device.info().fp64) {
    throw Error(ErrorKind::kDevice,
                fmt::format("bench --trade: found {} without double precision, allowed a device with fp64",
                            device.info().label()));
  }
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const TradeScene scene = trade_scene(options);
  std::vector<TradePoint> points;
  for (const TradeSensor& sensor : scene.sensors) {
    const std::size_t views = sensor.views.size();
    std::vector<RayResults> truth;
    {
      Way reference(device, scene, sensor, options_of(Quality::kReference));
      truth = all_results(reference, views);
    }
    Way balanced(device, scene, sensor, options_of(Quality::kBalanced));
    for (const Candidate& candidate : candidates(options, moves(sensor))) {
      Way way(device, scene, sensor, candidate.options);
      TradePoint point;
      point.sensor = sensor.name;
      point.is_camera = sensor.is_camera;
      point.variant = candidate.name;
      point.is_quality = candidate.is_quality;
      const std::vector<RayResults> found =
          candidate.name == quality_names().back() ? truth : all_results(way, views);
      if (sensor.is_camera) {
        compare_pictures(found, truth, point);
      } else {
        compare_sweeps(found, truth, point);
      }
      time_both(way, balanced, views, options.repeats, point);
      note(fmt::format(
          "{} {}: {:.1f} ms, error {:.3g}", sensor.name, candidate.name, point.frame_ms.median, point.error));
      points.push_back(std::move(point));
    }
  }
  mark_front(points);
  return points;
}

std::vector<Row> trade_rows(const std::vector<TradePoint>& points) {
  std::vector<Row> rows;
  for (const TradePoint& p : points) {
    const std::string base = fmt::format("trade/{}/{}/", p.sensor, p.variant);
    rows.push_back({base + "frame", p.frame_ms.median, "ms", p.frame_ms.half_iqr});
    rows.push_back({base + "times_balanced", p.times_balanced.median, "x", p.times_balanced.half_iqr});
    for (const auto& [stage, ms] : p.stage_ms) rows.push_back({base + stage, ms, "ms", 0.0});
    if (p.is_camera) {
      rows.push_back({base + "error_rms", p.error, "of 1", 0.0});
      rows.push_back({base + "error_worst", p.worst, "of 1", 0.0});
    } else {
      rows.push_back({base + "distance_error_mean", p.error, "m", 0.0});
      rows.push_back({base + "distance_error_median", p.median_m, "m", 0.0});
      rows.push_back({base + "distance_error_p99", p.p99_m, "m", 0.0});
      rows.push_back({base + "ray_drop_changed", p.changed_share, "of rays", 0.0});
    }
    rows.push_back({base + "on_front", p.on_front ? 1.0 : 0.0, "", 0.0});
  }
  return rows;
}

std::string trade_table(const std::vector<TradePoint>& points) {
  std::string out, sensor;
  for (const TradePoint& p : points) {
    if (p.sensor != sensor) {
      sensor = p.sensor;
      out += fmt::format(
          "{:<26} {:>9} {:>8} {:>8} {:>15}", sensor, "ms/frame", "project", "blend", "x balanced");
      out +=
          p.is_camera
              ? fmt::format(" {:>9} {:>9}  front\n", "PSNR dB", "worst")
              : fmt::format(" {:>9} {:>10} {:>9} {:>9}  front\n", "mean mm", "median mm", "p99 mm", "drop %");
    }
    out += fmt::format("{:<26} {:>9.2f} {:>8.2f} {:>8.2f} {:>6.3f} +- {:<5.3f}",
                       p.variant,
                       p.frame_ms.median,
                       p.stage_ms.at("project"),
                       p.stage_ms.at("blend"),
                       p.times_balanced.median,
                       p.times_balanced.half_iqr);
    const char* front = p.on_front ? "*" : "";
    out += p.is_camera ? fmt::format(" {:>9.2f} {:>9.2g}  {}\n", p.psnr_db, p.worst, front)
                       : fmt::format(" {:>9.3f} {:>10.3g} {:>9.3g} {:>9.3g}  {}\n",
                                     1e3 * p.error,
                                     1e3 * p.median_m,
                                     1e3 * p.p99_m,
                                     100.0 * p.changed_share,
                                     front);
  }
  return out;
}

}  // namespace simuli::bench
