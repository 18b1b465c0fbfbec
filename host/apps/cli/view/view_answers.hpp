#pragma once
// What the viewer's server asks of what is shown: a scene (view_session.hpp) or a log (log_session.hpp).
#include <string>

#include "host/apps/cli/view/view_request.hpp"

namespace simuli::cli {

/// Calls may come from any thread. Requests are refused with Error.
class ViewAnswers {
 public:
  ViewAnswers() = default;
  ViewAnswers(const ViewAnswers&) = delete;
  ViewAnswers& operator=(const ViewAnswers&) = delete;
  virtual ~ViewAnswers() = default;

  /// JSON: json_of_drive(), names, actors.
  [[nodiscard]] virtual std::string describe() const = 0;
  /// JSON: "version", a number that changes with what is described, and what takes long (Activity::now()).
  [[nodiscard]] virtual std::string progress() const = 0;
  /// Replies of two parts: a little-endian u32, that many bytes of JSON (times, poses, boxes), zeros up to the
  /// next multiple of 4, and a JPEG or PNG; or returns as float x, y, z (scene frame, m), intensity, ring
  /// (row of the sensor, from the top; 0 of a ray list), time (share of the sweep), actor (0 none, else one
  /// more than its number in describe()). With request.points a picture's info has "points", how many returns of
  /// that LiDAR are in it, and its bytes begin with them: these values, then x and y in parts of its sides.
  [[nodiscard]] virtual std::string picture(const ViewRequest& request) = 0;
  [[nodiscard]] virtual std::string sweep(const ViewRequest& request) = 0;
  /// JSON: what is at request.pixel; null for what there is not.
  [[nodiscard]] virtual std::string probe(const ViewRequest& request) = 0;

  /// For what alone a scene can do; else Error{kUsage}.
  virtual std::string duplicate(const std::string& json);
  virtual std::string add(const std::string& file_name, const std::string& bytes, double time_s);
  [[nodiscard]] virtual std::string command(const ViewRequest& request) const;
};

}  // namespace simuli::cli
