#include "io/export/road_line.hpp"

#include <algorithm>
#include <cmath>

namespace simuli {
namespace {

constexpr double kStep_m = 0.25;      // closer positions do not define a direction
constexpr double kTangent_m = 1.5;    // least distance of the neighbours that define a tangent, on both sides
constexpr double kLongest_m = 100.0;  // of two arcs
constexpr double kStraight_per_m = 1e-6;  // below this curvature some readers draw a straight line
constexpr double kDetour = 1.6;           // largest length of two arcs relative to the straight line

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double heading_of(const Eigen::Vector2d& direction) { return std::atan2(direction.y(), direction.x()); }

/// A position and its distance along the drive; driving backwards decreases it.
struct Step {
  Eigen::Vector3d place;
  double along_m;
};

std::vector<Step> steps_of(const std::vector<Pose>& rig) {
  std::vector<Step> out{{rig.front().translation, 0.0}};
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  double sign = 1.0;
  for (const Pose& pose : rig) {
    const Eigen::Vector2d step = (pose.translation - out.back().place).head<2>();
    if (step.norm() < kStep_m) continue;
    if (step.dot(before) < 0.0) sign = -sign;
    before = step;
    out.push_back({pose.translation, out.back().along_m + sign * step.norm()});
  }
  return out;
}

/// Returns the positions at which the drive was farther than before. The direction in which it drove longer is
/// forward.
std::vector<Eigen::Vector3d> advance(const std::vector<Pose>& rig) {
  const std::vector<Step> steps = steps_of(rig);
  const auto [least, most] = std::minmax_element(
      steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.along_m < b.along_m; });
  const double sign = most->along_m >= -least->along_m ? 1.0 : -1.0;
  std::vector<Eigen::Vector3d> out{steps.front().place};
  double farthest = 0.0, before = 0.0;
  for (const Step& step : steps) {
    const double along = sign * step.along_m;
    // After a reversal a position may be a step away from the earlier one.
    const double least_gain = before < farthest ? 2.0 * kStep_m : 0.0;
    before = along;
    if (along <= farthest + least_gain) continue;
    farthest = before = along;
    out.push_back(step.place);
  }
  if (before == farthest && out.size() > 1) {  // at the last pose, less than a step ahead
    const Eigen::Vector2d ahead = (out.back() - out[out.size() - 2]).head<2>().normalized();
    const Eigen::Vector2d rest = (rig.back().translation - out.back()).head<2>();
    out.back().head<2>() += std::max(0.0, rest.dot(ahead)) * ahead;
  }
  return out;
}

/// Returns the tangent of the circle through a, b and c at b.
Eigen::Vector2d tangent(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d to = b - a, from = c - b;
  const Eigen::Vector2d sum = to / to.squaredNorm() + from / from.squaredNorm();
  return sum.norm() * from.norm() > 1e-6 ? sum.normalized() : from.normalized();
}

/// Returns the direction in which a circle leaves b if it enters a with direction `at_a`.
Eigen::Vector2d mirrored(const Eigen::Vector2d& at_a, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d chord = (b - a).normalized();
  return (2.0 * at_a.dot(chord) * chord - at_a).normalized();
}

std::vector<Eigen::Vector2d> tangents_of(const std::vector<Eigen::Vector2d>& p) {
  const std::size_t last = p.size() - 1;
  std::vector<Eigen::Vector2d> out(p.size());
  if (last == 1) return {(p[1] - p[0]).normalized(), (p[1] - p[0]).normalized()};
  for (std::size_t i = 1; i < last; ++i) {
    std::size_t a = i - 1, c = i + 1;
    while (a > 0 && (p[i] - p[a]).norm() < kTangent_m) --a;
    while (c < last && (p[c] - p[i]).norm() < kTangent_m) ++c;
    out[i] = tangent(p[a], p[i], p[c]);
  }
  std::size_t second = 1, second_last = last - 1;
  while (second < last - 1 && (p[second] - p[0]).norm() < kTangent_m) ++second;
  while (second_last > 1 && (p[last] - p[second_last]).norm() < kTangent_m) --second_last;
  out[0] = mirrored(out[second], p[0], p[second]);
  out[last] = mirrored(out[second_last], p[second_last], p[last]);
  return out;
}

RoadPiece straight(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return {from, heading_of(to - from), (to - from).norm(), 0.0};
}

/// Returns the arc that starts at `from` in the unit direction `along` and ends at `to`.
RoadPiece arc(const Eigen::Vector2d& from, const Eigen::Vector2d& along, const Eigen::Vector2d& to) {
  const Eigen::Vector2d chord = to - from;
  const double turn = 2.0 * std::atan2(cross(along, chord), along.dot(chord));
  const double curvature = 2.0 * std::sin(0.5 * turn) / chord.norm();
  if (!(std::abs(curvature) >= kStraight_per_m)) return straight(from, to);
  return {from, heading_of(along), turn / curvature, curvature};
}

/// Returns two arcs from a to b with a common tangent (K. M. Bolton, Biarc curves, 1975); the control triangles
/// have equal sides.
std::vector<RoadPiece> biarc(const Eigen::Vector2d& a,
                             const Eigen::Vector2d& along_a,
                             const Eigen::Vector2d& b,
                             const Eigen::Vector2d& along_b) {
  const Eigen::Vector2d v = b - a;
  const double p = v.dot(along_a + along_b), q = 2.0 * (1.0 - along_a.dot(along_b));
  const double side =
      q > 1e-12 ? (std::sqrt(p * p + q * v.squaredNorm()) - p) / q : v.squaredNorm() / (2.0 * p);
  if (!(side > 1e-6) || !std::isfinite(side)) return {};
  const Eigen::Vector2d middle = 0.5 * (a + b + side * (along_a - along_b));
  const Eigen::Vector2d there = (b - a - side * (along_a + along_b)) / (2.0 * side);
  if ((middle - a).norm() < 1e-6 || (b - middle).norm() < 1e-6) return {};
  return {arc(a, along_a, middle), arc(middle, there.normalized(), b)};
}

struct Nearest {
  double distance_m = 0.0;
  double along_m = 0.0;
};

Nearest nearest_on(const RoadPiece& piece, const Eigen::Vector2d& place) {
  const Eigen::Vector2d along(std::cos(piece.heading_rad), std::sin(piece.heading_rad));
  const Eigen::Vector2d from = place - piece.start;
  double s = from.dot(along);
  if (piece.curvature_per_m != 0.0) {
    const double radius = 1.0 / piece.curvature_per_m;
    const double side = cross(along, from);
    // From the angle at the centre; arcs never exceed half a circle.
    s = radius * std::atan2(s / radius, 1.0 - side / radius);
  }
  s = std::clamp(s, 0.0, piece.length_m);
  return {(piece.at(s) - place).norm(), s};
}

Nearest nearest_on(const std::vector<RoadPiece>& pieces, const Eigen::Vector2d& place) {
  Nearest best{HUGE_VAL, 0.0};
  double before = 0.0;
  for (const RoadPiece& piece : pieces) {
    const Nearest here = nearest_on(piece, place);
    if (here.distance_m < best.distance_m) best = {here.distance_m, before + here.along_m};
    before += piece.length_m;
  }
  return best;
}

double length_of(const std::vector<RoadPiece>& pieces) {
  double sum = 0.0;
  for (const RoadPiece& piece : pieces) sum += piece.length_m;
  return sum;
}

class Fit {
 public:
  explicit Fit(const std::vector<Eigen::Vector2d>& places) : p_(places), along_(tangents_of(places)) {}

  /// Returns the pieces from `first` to `last`, which are adjacent or near all positions between them; empty
  /// otherwise.
  [[nodiscard]] std::vector<RoadPiece> between(std::size_t first, std::size_t last) const {
    std::vector<RoadPiece> out = biarc(p_[first], along_[first], p_[last], along_[last]);
    const double length = length_of(out);
    if (length > kDetour * (p_[last] - p_[first]).norm()) out.clear();
    if (last > first + 1 && length > kLongest_m) out.clear();
    for (std::size_t i = first + 1; i < last && !out.empty(); ++i) {
      if (nearest_on(out, p_[i]).distance_m > RoadLine::kTolerance_m) out.clear();
    }
    return out;
  }

  /// Returns the farthest index that two arcs reach, found by doubling and bisection.
  [[nodiscard]] std::size_t farthest(std::size_t first) const {
    std::size_t reach = 1, add = 1;
    const auto fits = [&](std::size_t n) {
      return first + n < p_.size() && !between(first, first + n).empty();
    };
    for (; fits(reach + add); add *= 2) reach += add;
    for (; add > 0; add /= 2) {
      if (fits(reach + add)) reach += add;
    }
    return first + reach;
  }

 private:
  const std::vector<Eigen::Vector2d>& p_;
  std::vector<Eigen::Vector2d> along_;
};

/// Shortens the line such that its length is slightly above its single-precision value: CARLA requests the
/// position at that value and finds none at the very end of a road.
void cut(RoadLine& line) {
  constexpr double kAbove_m = 5e-8;
  const double length = length_of(line.pieces);
  double rest = length - std::floor((length - kAbove_m) / RoadLine::kGrid_m) * RoadLine::kGrid_m - kAbove_m;
  while (line.pieces.size() > 1 && line.pieces.back().length_m <= rest) {
    rest -= line.pieces.back().length_m;
    line.pieces.pop_back();
  }
  line.pieces.back().length_m -= rest;
  for (RoadPosition& place : line.places) place.s_m = std::min(place.s_m, length_of(line.pieces));
}

/// Returns a line of 10 m around the rig's position.
RoadLine standing(const Pose& rig) {
  const Eigen::Vector2d x = (rig.rotation * Eigen::Vector3d::UnitX()).head<2>();
  const Eigen::Vector2d along = x.norm() > 1e-3 ? x.normalized() : Eigen::Vector2d::UnitX();
  const double half = 0.5 * RoadLine::kShortest_m;
  const Eigen::Vector2d place = rig.translation.head<2>();
  RoadLine out{{straight(place - half * along, place + half * along)}, {{half, rig.translation}}};
  cut(out);
  return out;
}

}  // namespace

Eigen::Vector2d RoadPiece::at(double along_m) const {
  const double turn = 0.5 * along_m * curvature_per_m;
  const double chord = std::abs(turn) > 1e-9 ? along_m * std::sin(turn) / turn : along_m;
  return start + chord * Eigen::Vector2d(std::cos(heading_rad + turn), std::sin(heading_rad + turn));
}

double RoadLine::length_m() const { return length_of(pieces); }

RoadLine road_line(const std::vector<Pose>& rig) {
  const std::vector<Eigen::Vector3d> places = advance(rig);
  std::vector<Eigen::Vector2d> flat;
  for (const Eigen::Vector3d& place : places) flat.emplace_back(place.head<2>());
  double driven = 0.0;
  for (std::size_t i = 1; i < flat.size(); ++i) driven += (flat[i] - flat[i - 1]).norm();
  if (driven < 4.0 * kStep_m) return standing(rig.front());
  const Fit fit(flat);
  RoadLine out;
  double before = 0.0;
  for (std::size_t first = 0; first + 1 < flat.size();) {
    const std::size_t last = fit.farthest(first);
    std::vector<RoadPiece> pieces = fit.between(first, last);
    if (pieces.empty()) pieces = {straight(flat[first], flat[last])};
    for (std::size_t i = first; i < last; ++i) {
      out.places.push_back({before + nearest_on(pieces, flat[i]).along_m, places[i]});
    }
    before += length_of(pieces);
    out.pieces.insert(out.pieces.end(), pieces.begin(), pieces.end());
    first = last;
  }
  out.places.push_back({before, places.back()});
  cut(out);
  return out;
}

}  // namespace simuli
