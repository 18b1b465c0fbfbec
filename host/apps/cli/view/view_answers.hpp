#pragma once
// Requests of the viewer's server to a scene (view_session.hpp) or a log (log_session.hpp).
#include <string>

#include "host/apps/cli/view/view_request.hpp"

namespace simuli::cli {

/// Calls may come from any thread. Refused requests throw Error.
class ViewAnswers {
 public:
  ViewAnswers() = default;
  ViewAnswers(const ViewAnswers&) = delete;
  ViewAnswers& operator=(const ViewAnswers&) = delete;
  virtual ~ViewAnswers() = default;

  /// Returns JSON: json_of_drive(), names, actors.
  [[nodiscard]] virtual std::string describe() const = 0;
  /// Returns JSON: "version", a number that changes with the description, and long-running work
  /// (Activity::now()).
  [[nodiscard]] virtual std::string progress() const = 0;
  /// Returns replies of two parts: a little-endian u32 with the size of the JSON (times, poses, boxes) that
  /// follows, zeros up to the next multiple of 4, and a JPEG or PNG; for sweeps, returns as float x, y, z
  /// (scene frame, m), intensity, ring (beam of the sensor, from the top; 0 for a ray list), time (share of the
  /// sweep), actor (0: none; else 1 + its index in describe()). With request.points the JSON has "points", the
  /// number of returns of that LiDAR in the picture, and the payload begins with their values, followed by x
  /// and y as shares of the picture's sides.
  [[nodiscard]] virtual std::string picture(const ViewRequest& request) = 0;
  [[nodiscard]] virtual std::string sweep(const ViewRequest& request) = 0;
  /// Returns JSON: the values at request.pixel; null for missing ones.
  [[nodiscard]] virtual std::string probe(const ViewRequest& request) = 0;

  /// Only scenes support edits; logs throw Error{kUsage}.
  virtual std::string duplicate(const std::string& json);
  virtual std::string add(const std::string& file_name, const std::string& bytes, double time_s);
  [[nodiscard]] virtual std::string command(const ViewRequest& request) const;
};

}  // namespace simuli::cli
