#include "io/synth/long_street.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include "io/synth/street_world.hpp"

namespace simuli {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPiece_m = LongStreet::kPiece_m;
constexpr int kStraightAtEnds = 7;  // pieces; longer than kMargin_m
constexpr double kDegree_rad = std::numbers::pi / 180.0;
constexpr double kFar_m = 1e4;
/// Rays that start farther beside the street are not a sensor's. Radii of bends are larger.
constexpr double kBeside_m = 100.0;
constexpr double kCrossingHalfWidth_m = 5.0;

/// Rotation from a piece to the next: about the vertical in bends, about the lateral axis on hills, never both.
struct Joint {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;  // positive: downhill
};

struct Plan {
  std::vector<Joint> joints;        // joints[k]: from piece k to k + 1
  std::vector<bool> are_crossings;  // by piece
};

/// Plans straight pieces, and between them alternately a bend, a crossing and a hill. Bends turn back before
/// the street could intersect itself.
Plan plan_street(std::size_t pieces, std::uint64_t seed) {
  Plan plan{std::vector<Joint>(pieces), std::vector<bool>(pieces, false)};
  StreetDice dice(seed ^ 0x5851f42d4c957f2dULL);
  double heading_rad = 0.0;
  int kind = 0;
  std::size_t k = kStraightAtEnds + 1;
  while (k + 14 + kStraightAtEnds < pieces) {
    if (kind == 0) {
      const int turns = 4 + static_cast<int>(dice.between(0.0, 3.0));
      const double most = 8.0 * kDegree_rad;
      const bool is_left =
          std::abs(heading_rad) > 12.0 * kDegree_rad ? heading_rad < 0.0 : dice.between(0.0, 1.0) < 0.5;
      const double yaw = (is_left ? 1.0 : -1.0) * dice.between(0.5 * most, most);
      for (int i = 0; i < turns; ++i) plan.joints[k++].yaw_rad = yaw;
      heading_rad += turns * yaw;
    } else if (kind == 1) {
      plan.are_crossings[k + 1] = true;
      k += 2;
    } else {
      const double pitch = (dice.between(0.0, 1.0) < 0.5 ? 1.0 : -1.0) * dice.between(0.8, 1.4) * kDegree_rad;
      for (const double share : {1.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0, -1.0})
        plan.joints[k++].pitch_rad = share * pitch;
    }
    k += 1 + static_cast<std::size_t>(dice.between(0.0, 3.0));  // straight
    kind = (kind + 1) % 3;
  }
  return plan;
}

std::vector<StreetSolid> solids_of(
    std::size_t k, bool is_crossing, bool is_first, bool is_last, std::uint64_t seed) {
  std::vector<StreetSolid> solids;
  StreetDice dice(seed + 0x9e3779b97f4a7c15ULL * (k + 1));
  const double from = kPiece_m * static_cast<double>(k), to = from + kPiece_m, middle = 0.5 * (from + to);
  constexpr double kOverlap_m = 4.0;  // across the planes between pieces, which cut the solids
  solids.push_back(street_box(
      StreetMaterial::kAsphalt, {-kFar_m, -kFar_m, -1.0}, {kFar_m, kFar_m, 0.0}, {0.33, 0.33, 0.34}, 0.16));
  solids.back().centre.setZero();
  std::vector<std::pair<double, double>> built{{from - kOverlap_m, to + kOverlap_m}};
  if (is_crossing) {
    built = {{from - kOverlap_m, middle - kCrossingHalfWidth_m},
             {middle + kCrossingHalfWidth_m, to + kOverlap_m}};
  }
  for (const double side : {-1.0, 1.0}) {
    const double near_y = side > 0.0 ? kRoadHalfWidth_m : -kFar_m,
                 far_y = side > 0.0 ? kFar_m : -kRoadHalfWidth_m;
    for (const auto& [low, high] : built) {
      const double start = is_crossing ? low : -kFar_m, end = is_crossing ? high : kFar_m;
      solids.push_back(street_box(StreetMaterial::kPavement,
                                  {start, near_y, -1.0},
                                  {end, far_y, kKerbHeight_m},
                                  {0.58, 0.56, 0.53},
                                  0.3));
      solids.back().centre.setZero();
      const std::size_t first = solids.size();
      add_street_buildings(solids, dice, side, low, high);
      for (std::size_t i = first; is_crossing && i < solids.size(); ++i) {
        solids[i].high.x() = std::min(solids[i].high.x(), high);
      }
    }
    if (is_crossing) {  // a house ends the side street
      const double y = side * 58.0;
      solids.push_back(street_box(StreetMaterial::kFacade,
                                  {middle - 14.0, std::min(y, y + side * 10.0), 0.0},
                                  {middle + 14.0, std::max(y, y + side * 10.0), 11.0},
                                  {0.72, 0.42, 0.32},
                                  0.4));
    } else {
      add_street_furniture(solids, dice, side, from, to - 4.0);
    }
  }
  for (const bool is_end : {is_first, is_last}) {
    if (!is_end) continue;
    const double x = is_first ? from + 1.0 : to - 5.0;
    solids.push_back(
        street_box(StreetMaterial::kFacade, {x, -24.0, 0.0}, {x + 4.0, 24.0, 12.0}, {0.80, 0.72, 0.55}, 0.4));
  }
  return solids;
}

/// Intersects the ray with the part of a box beyond `start`; if the start is inside, the intersection is the
/// cutting plane.
bool meet_cut_box(const StreetSolid& solid,
                  const Vector3d& origin,
                  const Vector3d& direction,
                  double start,
                  const Vector3d& start_normal,
                  StreetCrossing& nearest) {
  double enter = start, leave = nearest.range;
  int axis = -1;
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0.0) {
      if (!(origin[i] > solid.low[i] && origin[i] < solid.high[i])) return false;
      continue;
    }
    const double a = (solid.low[i] - origin[i]) / direction[i],
                 b = (solid.high[i] - origin[i]) / direction[i];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
    if (!(enter < leave)) return false;
  }
  if (axis < 0 && start_normal.isZero(0.0)) return false;  // a ray that starts inside does not intersect
  nearest.range = enter;
  nearest.normal = start_normal;
  if (axis >= 0) nearest.normal = (direction[axis] > 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
  return true;
}

}  // namespace

struct LongStreet::State {
  /// The plane at the end of piece k.
  struct Plane {
    Vector3d point = Vector3d::Zero();
    Vector3d normal = Vector3d::UnitX();  // towards the next piece
    [[nodiscard]] double side(const Vector3d& p) const { return (p - point).dot(normal); }
  };
  /// The x axis of its frame is s.
  struct Piece {
    Pose world_from_piece;
    Vector3d start = Vector3d::Zero();  // centre, world
    bool is_crossing = false;
    mutable std::mutex making;
    mutable std::atomic<const std::vector<StreetSolid>*> solids = nullptr;
    ~Piece() { delete solids.load(); }
  };

  std::uint64_t seed = 0;
  double first_s_m = 0.0;  // of piece 0
  std::vector<std::unique_ptr<Piece>> pieces;
  std::vector<Plane> planes;  // planes[k]: between pieces k and k + 1; none after the last
  std::vector<Joint> joints;
  std::vector<Actor> cars;
  std::vector<StreetSolid> car;

  [[nodiscard]] const std::vector<StreetSolid>& solids(std::size_t k) const {
    const Piece& piece = *pieces[k];
    if (const auto* const made = piece.solids.load(std::memory_order_acquire)) return *made;
    const std::lock_guard lock(piece.making);
    if (const auto* const made = piece.solids.load()) return *made;
    piece.solids =
        new std::vector<StreetSolid>(solids_of(k, piece.is_crossing, k == 0, k + 1 == pieces.size(), seed));
    return *piece.solids.load();
  }

  [[nodiscard]] bool holds(std::size_t k, const Vector3d& p) const {
    if (k > 0 && planes[k - 1].side(p) < 0.0) return false;
    if (k < planes.size() && planes[k].side(p) >= 0.0) return false;
    const Vector3d left = pieces[k]->world_from_piece.rotation * Vector3d::UnitY();
    return std::abs((p - pieces[k]->start).dot(left)) < kBeside_m &&
           (p - pieces[k]->start).norm() < 3.0 * kBeside_m;
  }
  /// Returns the piece that contains the point; pieces.size() far from the street.
  [[nodiscard]] std::size_t piece_at(const Vector3d& p) const {
    thread_local std::size_t last = 0;  // rays of a sensor start close together
    if (last < pieces.size() && holds(last, p)) return last;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      if (holds(k, p)) return last = k;
    }
    return pieces.size();
  }

  /// Returns the first static solid along the ray, piece by piece. `normal` in world coordinates; `met_in` is
  /// its piece.
  const StreetSolid* meet_standing(const Vector3d& origin,
                                   const Vector3d& direction,
                                   std::size_t k,
                                   StreetCrossing& nearest,
                                   std::size_t& met_in) const {
    double start = 0.0;
    Vector3d start_normal = Vector3d::Zero();  // world; zero: the ray's own start
    for (;;) {
      const Piece& piece = *pieces[k];
      double end = nearest.range;
      std::size_t next = pieces.size();
      Vector3d end_normal = Vector3d::Zero();
      const auto leave_by = [&](std::size_t plane, std::size_t to, double sign) {
        const double across = sign * direction.dot(planes[plane].normal);
        if (!(across > 0.0)) return;
        const double range = std::max(-sign * planes[plane].side(origin) / across, start);
        if (range >= end) return;
        end = range;
        next = to;
        end_normal = -sign * planes[plane].normal;
      };
      if (k < planes.size()) leave_by(k, k + 1, 1.0);
      if (k > 0) leave_by(k - 1, k - 1, -1.0);
      const Quaterniond turn = piece.world_from_piece.rotation.conjugate();
      const Vector3d from = turn * (origin - piece.world_from_piece.translation), along = turn * direction;
      const Vector3d inverse = along.cwiseInverse(), cut = turn * start_normal;
      StreetCrossing found{end, Vector3d::Zero()};
      const StreetSolid* met = nullptr;
      for (const StreetSolid& solid : solids(k)) {
        const bool is_met = solid.shape == meet_box ? meet_cut_box(solid, from, along, start, cut, found)
                                                    : solid.shape(solid, from, along, inverse, found);
        if (is_met) met = &solid;
      }
      if (met != nullptr) {
        nearest = {found.range, piece.world_from_piece.rotation * found.normal};
        met_in = k;
        return met;
      }
      if (next == pieces.size()) return nullptr;
      k = next;
      start = end;
      start_normal = end_normal;
    }
  }
};

LongStreet::LongStreet(double length_m, std::uint64_t seed) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.seed = seed;
  s.first_s_m = -kPiece_m * kStraightAtEnds;
  const auto driven = static_cast<std::size_t>(std::ceil(std::max(length_m, 0.0) / kPiece_m));
  const std::size_t count = driven + 2 * kStraightAtEnds;
  const Plan plan = plan_street(count, seed);
  s.joints = plan.joints;
  Vector3d start(s.first_s_m, 0.0, 0.0);
  Quaterniond rotation = Quaterniond::Identity();
  for (std::size_t k = 0; k < count; ++k) {
    auto piece = std::make_unique<State::Piece>();
    const Vector3d along = rotation * Vector3d::UnitX();
    piece->start = start;
    piece->world_from_piece = {rotation, start - kPiece_m * static_cast<double>(k) * along};
    piece->is_crossing = plan.are_crossings[k];
    s.pieces.push_back(std::move(piece));
    start += kPiece_m * along;
    const Joint& joint = plan.joints[k];
    rotation = (rotation * Eigen::AngleAxisd(joint.yaw_rad, Vector3d::UnitZ()) *
                Eigen::AngleAxisd(joint.pitch_rad, Vector3d::UnitY()))
                   .normalized();
    if (k + 1 < count) {
      s.planes.push_back({start, (along + rotation * Vector3d::UnitX()).normalized()});
    }
  }
  add_street_car(s.car, Vector3d::Zero(), {0.88, 0.62, 0.10});
}

LongStreet::~LongStreet() = default;

void LongStreet::set_traffic(std::vector<Actor> cars) { state_->cars = std::move(cars); }

std::size_t LongStreet::pieces() const { return state_->pieces.size(); }

std::size_t LongStreet::pieces_held() const {
  return static_cast<std::size_t>(
      std::count_if(state_->pieces.begin(), state_->pieces.end(), [](const auto& piece) {
        return piece->solids.load() != nullptr;
      }));
}

void LongStreet::forget_beyond(double s_m, double distance_m) {
  for (std::size_t k = 0; k < state_->pieces.size(); ++k) {
    const double middle_m = state_->first_s_m + kPiece_m * (static_cast<double>(k) + 0.5);
    if (std::abs(middle_m - s_m) > distance_m) delete state_->pieces[k]->solids.exchange(nullptr);
  }
}

Pose LongStreet::world_from_street(double s_m, double left_m) const {
  const State& s = *state_;
  const double at = (s_m - s.first_s_m) / kPiece_m;
  const auto last = static_cast<double>(s.pieces.size() - 1);
  const auto k = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, last));
  // A parabola from the centre of a piece to the centre of the next one; its direction changes uniformly.
  const double in_piece = at - static_cast<double>(k);
  const bool is_behind = in_piece >= 0.5;
  const std::size_t low = is_behind ? k : (k > 0 ? k - 1 : 0);
  const std::size_t high = std::min(low + 1, s.pieces.size() - 1);
  const Quaterniond& before = s.pieces[low]->world_from_piece.rotation;
  const Quaterniond& behind = s.pieces[high]->world_from_piece.rotation;
  Pose pose;
  if (low == high || (k == 0 && !is_behind)) {
    const State::Piece& piece = *s.pieces[k];
    pose = {piece.world_from_piece.rotation,
            piece.start + piece.world_from_piece.rotation * Vector3d(in_piece * kPiece_m, 0.0, 0.0)};
  } else {
    const double u = is_behind ? in_piece - 0.5 : in_piece + 0.5;  // fraction of the way between the centres
    const Vector3d& joint = s.pieces[high]->start;
    const Vector3d from = joint - before * Vector3d(0.5 * kPiece_m, 0.0, 0.0);
    const Vector3d to = joint + behind * Vector3d(0.5 * kPiece_m, 0.0, 0.0);
    pose.rotation = before.slerp(u, behind);
    pose.translation = (1.0 - u) * (1.0 - u) * from + 2.0 * u * (1.0 - u) * joint + u * u * to;
  }
  pose.translation += pose.rotation * Vector3d(0.0, left_m, 0.0);
  // Projects to the road: on a hilltop the parabola cuts the corner.
  const std::size_t on = s.piece_at(pose.translation);
  if (on < s.pieces.size()) {
    const Vector3d up = s.pieces[on]->world_from_piece.rotation * Vector3d::UnitZ();
    pose.translation -= (pose.translation - s.pieces[on]->start).dot(up) * up;
  }
  return pose;
}

StreetHit LongStreet::trace(const Vector3d& origin,
                            const Vector3d& direction,
                            double time_s,
                            double max_range) const {
  const State& s = *state_;
  StreetHit hit;
  if (!(origin.allFinite() && direction.allFinite() && std::isfinite(time_s) && max_range > 0.0)) return hit;
  hit.colour = street_sky(direction);
  const std::size_t first = s.piece_at(origin);
  if (first == s.pieces.size()) return hit;
  StreetCrossing nearest{max_range, Vector3d::Zero()};
  std::size_t in = 0;
  const StreetSolid* met = s.meet_standing(origin, direction, first, nearest, in);
  Pose own_from_world = met == nullptr ? Pose{} : s.pieces[in]->world_from_piece.inverse();
  for (const Actor& car : s.cars) {
    if (!car.is_there(time_s)) continue;
    // Approximate position: between two keys a car drives less than its length.
    const KeyShare share = car.key_share(time_s);
    const Vector3d to = car.track[share.key].world_from_actor.translation - origin;
    constexpr double kReach_m = 10.0;
    const double ahead = to.dot(direction);
    if (ahead < -kReach_m || ahead > nearest.range + kReach_m) continue;
    if (to.squaredNorm() - ahead * ahead > kReach_m * kReach_m) continue;
    Pose car_from_world = car.at(time_s).inverse();
    car_from_world.translation.z() += 0.5 * kCarHeight_m;  // tracks are those of the box's centre
    const Vector3d from = car_from_world * origin, along = car_from_world.rotation * direction;
    StreetCrossing on_car{nearest.range, Vector3d::Zero()};
    for (const StreetSolid& solid : s.car) {
      if (!solid.shape(solid, from, along, along.cwiseInverse(), on_car)) continue;
      met = &solid;
      nearest = {on_car.range, car_from_world.rotation.conjugate() * on_car.normal};
      own_from_world = car_from_world;
      hit.on_car = true;
    }
  }
  if (met == nullptr) return hit;
  hit.hit = true;
  hit.range = nearest.range;
  hit.normal = nearest.normal;
  const StreetSurface surface = street_surface(*met,
                                               own_from_world * (origin + nearest.range * direction),
                                               own_from_world.rotation * nearest.normal,
                                               s.seed);
  hit.colour = (surface.albedo * street_light(nearest.normal)).cwiseMax(0.0).cwiseMin(1.0);
  hit.reflectance = surface.reflectance;
  return hit;
}

}  // namespace simuli
