#pragma once
// Speed and accuracy of each option of host/device/render/options/options.hpp.
#include <map>
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli::bench {

struct TradeOptions {
  std::vector<std::string> folders;  // a scene, and optionally a log of its frames; empty: the bench street
  std::string sensor;                // only this sensor of the scene; empty: all
  double image_scale = 1.0;          // for the scene's cameras
  int views = 3;                     // evenly spread over the recorded frames; the bench street has one view
  int repeats = 7;                   // timed renders per view
  std::string own_name;              // not empty: measures only `own` and the qualities
  RenderOptions own;
};

/// A set of options compared with the reference: double precision, exact extents, per-ray order and colours.
struct TradePoint {
  std::string sensor;      // name
  bool is_camera = false;  // false: LiDAR
  std::string variant;     // "extent=exact", or the name of a quality
  bool is_quality = false;
  Spread frame_ms;                         // per frame, from the call to the result on the device
  std::map<std::string, double> stage_ms;  // device time of its stages: rays, project, sort, bin, blend
  Spread times_balanced;                   // frame time relative to balanced, taken in turns
  double error = 0.0;                      // error of the front. Camera: RMS of the colours in [0, 1]; LiDAR:
                                           // mean |distance - reference|, m, of rays that return in both
  double psnr_db = 0.0;   // camera: relative to the reference's picture; inf for equal pictures
  double worst = 0.0;     // camera: largest colour error
  double median_m = 0.0;  // LiDAR: |distance - reference| of rays that return in both
  double p99_m = 0.0;
  double changed_share = 0.0;  // LiDAR: share of rays with a return in only one of both
  bool on_front =
      false;  // no other point is at least 3 % faster and not less accurate, or as fast and at least
              // 3 % more accurate
};

/// Marks the Pareto front of frame time and error of each sensor. The reference, whose error is 0 by
/// definition, is always on the front and otherwise excluded.
void mark_front(std::vector<TradePoint>& points);

/// Measures each single option and the four qualities. Throws Error{kUsage} for folders other than a scene or
/// a scene and a log, and for an unknown sensor; Error{kDevice} without double precision.
[[nodiscard]] std::vector<TradePoint> run_trade(const std::string& device_request,
                                                const TradeOptions& options,
                                                const Note& note);

/// Returns rows trade/<sensor>/<variant>/<metric>, or a text table.
[[nodiscard]] std::vector<Row> trade_rows(const std::vector<TradePoint>& points);
[[nodiscard]] std::string trade_table(const std::vector<TradePoint>& points);

}  // namespace simuli::bench
