#pragma once
// Speed against accuracy: what each named option of host/device/render/options/options.hpp costs and gains.
#include <map>
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli::bench {

struct TradeOptions {
  std::vector<std::string> folders;  // a scene, and a log of its frames if wanted; none: the bench street
  std::string sensor;                // only this one of the scene; empty: all
  double image_scale = 1.0;          // of the scene's cameras
  int views = 3;                     // spread evenly over what was recorded; the bench street has one
  int repeats = 7;                   // timed renders of each view
  std::string own_name;              // if given, only these options and the qualities are measured
  RenderOptions own;
};

/// One way to render, against the reference: double precision, exact extents, each ray's own order and
/// colours.
struct TradePoint {
  std::string sensor;      // name
  bool is_camera = false;  // else a LiDAR
  std::string variant;     // "extent=exact", or a quality's name
  bool is_quality = false;
  Spread frame_ms;                         // per frame, from call to result on the device
  std::map<std::string, double> stage_ms;  // of that, device time: rays, project, sort, bin, blend
  Spread times_balanced;                   // frame times over those of balanced, taken in turns
  double error = 0.0;     // what the front is drawn of. Camera: RMS of the colours in [0, 1]; LiDAR:
                          // mean |distance - reference|, m, of rays that return in both
  double psnr_db = 0.0;   // camera: of the picture against the reference's; inf for the same picture
  double worst = 0.0;     // camera: of all colours
  double median_m = 0.0;  // LiDAR: |distance - reference| of rays that return in both
  double p99_m = 0.0;
  double changed_share = 0.0;  // LiDAR: rays that return in one alone
  bool on_front = false;  // no other is at least 3 % faster and not less accurate, or as fast and at least
                          // 3 % more accurate
};

/// Marks what lies on each sensor's front of frame time and error; the reference is left out, as its error is
/// 0 by definition, and lies on it.
void mark_front(std::vector<TradePoint>& points);

/// Measures every option alone and the four qualities. Error{kUsage} for folders that are neither a scene nor
/// a scene and a log, or a sensor that is not there; Error{kDevice} without double precision.
[[nodiscard]] std::vector<TradePoint> run_trade(const std::string& device_request,
                                                const TradeOptions& options,
                                                const Note& note);

/// As rows trade/<sensor>/<variant>/<metric>, and as a table for people.
[[nodiscard]] std::vector<Row> trade_rows(const std::vector<TradePoint>& points);
[[nodiscard]] std::string trade_table(const std::vector<TradePoint>& points);

}  // namespace simuli::bench
