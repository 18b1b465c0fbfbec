// Parked vehicles of the detailed street.
#include <algorithm>
#include <array>
#include <cmath>

#include "bench/street/detail.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

const std::array<Vector3d, 9> kVehicleTints{{{0.70, 0.10, 0.10},
                                             {0.12, 0.24, 0.55},
                                             {0.85, 0.85, 0.85},
                                             {0.12, 0.12, 0.13},
                                             {0.55, 0.58, 0.60},
                                             {0.18, 0.42, 0.30},
                                             {0.88, 0.50, 0.12},
                                             {0.36, 0.30, 0.26},
                                             {0.45, 0.62, 0.74}}};

/// Lower half of a wheel in radii: half width, lower and upper height of each step.
constexpr std::array<std::array<double, 3>, 4> kTyreSteps{
    {{0.45, 0.0, 0.12}, {0.70, 0.12, 0.35}, {0.90, 0.35, 0.65}, {1.0, 0.65, 1.2}}};

/// Adds parts with x measured forwards from the vehicle's centre.
class VehicleParts {
 public:
  VehicleParts(StreetSide& to, const Vector3d& at, const Vector3d& tint)
      : to_(to),
        x_(at.x()),
        y_(std::abs(at.y())),
        // Cars on both sides are parked in the driving direction.
        forward_(at.y() < 0.0 ? 1.0 : -1.0),
        style_((forward_ > 0.0 ? 1U : 2U) + 4U * (1U + to.variety(60))),
        tint_(tint),
        paint_(0.04 + 0.6 * tint.mean()) {}

  void box(StreetMaterial material, double x0, double x1, double y0, double y1, double z0, double z1) {
    own(to_.of(material, tint_, paint_, style_)
            .box(x_ + forward_ * x0, x_ + forward_ * x1, y_ + y0, y_ + y1, z0, z1));
  }
  void box(StreetMaterial material, double x0, double x1, double half_y, double z0, double z1) {
    box(material, x0, x1, -half_y, half_y, z0, z1);
  }
  /// Adds a box cut off above the line from (xa, za) to (xb, zb) with xa <= xb.
  void cut(StreetMaterial material,
           double x0,
           double x1,
           double half_y,
           double z0,
           double z1,
           double xa,
           double za,
           double xb,
           double zb) {
    own(to_.of(material, tint_, paint_, style_)
            .cut(x_ + forward_ * x0,
                 x_ + forward_ * x1,
                 y_ - half_y,
                 y_ + half_y,
                 z0,
                 z1,
                 {forward_ * (za - zb), 0.0, xb - xa},
                 {x_ + forward_ * xa, y_, za}));
  }
  void tyres(double front, double rear, double radius, double half_y) {
    for (const double x : {front, rear}) {
      for (const double side : {-1.0, 1.0}) {
        // Approximates the wheel by steps; its upper part is painted on the body.
        for (const auto& [half, low, high] : kTyreSteps) {
          box(StreetMaterial::kTyre,
              x - half * radius,
              x + half * radius,
              side * (half_y - 0.2),
              side * half_y,
              low * radius,
              high * radius);
        }
      }
    }
  }
  void mirrors(double x, double half_y, double z) {
    for (const double side : {-1.0, 1.0}) {
      box(StreetMaterial::kPainted, x - 0.05, x + 0.06, side * half_y, side * (half_y + 0.16), z, z + 0.14);
    }
  }
  void number_plates(double front, double rear, double z) {
    box(StreetMaterial::kNumberPlate, front, front + 0.012, 0.26, z, z + 0.12);
    box(StreetMaterial::kNumberPlate, rear - 0.012, rear, 0.26, z, z + 0.12);
  }
  void shade(double rear, double front, double half_y) {
    to_.of(StreetMaterial::kShade, {0.33, 0.33, 0.34}, 0.1);
    to_.box(x_ + forward_ * rear, x_ + forward_ * front, y_ - half_y, y_ + half_y, -0.01, 0.003);
  }
  void rod(const Vector3d& from, const Vector3d& end, double radius) {
    to_.of(StreetMaterial::kPainted, {0.10, 0.10, 0.11}, 0.2);
    const auto placed = [&](const Vector3d& p) { return Vector3d(x_ + forward_ * p.x(), y_ + p.y(), p.z()); };
    to_.rod(placed(from), placed(end), radius);
  }
  void paint(const Vector3d& tint) {
    tint_ = tint;
    paint_ = 0.04 + 0.6 * tint.mean();
  }

 private:
  /// Sets the frame of the solid's patterns to the vehicle's frame.
  void own(StreetSolid& solid) const { solid.centre = {x_, to_.side() * y_, 0.0}; }

  StreetSide& to_;
  double x_, y_, forward_;
  std::uint32_t style_;
  Vector3d tint_;
  double paint_;
};

void add_passenger_car(StreetSide& to, const Vector3d& at, bool is_estate, bool is_small) {
  VehicleParts car(to, at, to.dice().pick(kVehicleTints));
  const double front = is_small ? 1.75 : is_estate ? 2.25 : 2.1, rear = -front;
  const double half = is_small ? 0.80 : 0.88, roof = is_small ? 1.50 : 1.46;
  const double bonnet = front - (is_small ? 0.85 : 1.15);
  const double sill = 0.26, belt = 0.92;
  car.shade(rear, front, half);
  car.box(StreetMaterial::kCarBody, rear, bonnet, half, sill, belt);
  car.cut(StreetMaterial::kCarBody, bonnet, front, half, sill, belt, bonnet, belt, front, 0.72);
  // The cabin consists of two halves with one sloping window each.
  const double cabin = half - 0.10, foot = bonnet + 0.25, middle = -0.1;
  car.cut(StreetMaterial::kCarCabin, middle, foot, cabin, belt, roof, foot - 0.75, roof, foot, belt);
  const double back = rear + 0.04;
  const double slope = is_estate ? 0.2 : 0.55;
  car.cut(StreetMaterial::kCarCabin, back, middle, cabin, belt, roof, back, belt, back + slope, roof);
  car.tyres(front - 0.82, rear + 0.80, 0.30, half - 0.01);
  car.mirrors(foot - 0.45, half, 0.94);
  car.number_plates(front, rear, 0.44);
  car.box(StreetMaterial::kPainted, front - 0.01, front + 0.03, half - 0.02, 0.28, 0.40);  // bumpers
  car.box(StreetMaterial::kPainted, rear - 0.03, rear + 0.01, half - 0.02, 0.28, 0.40);
  if (is_estate) {
    for (const double side : {-1.0, 1.0}) {
      car.rod(
          {back + 0.3, side * (cabin - 0.06), roof + 0.05}, {0.5, side * (cabin - 0.06), roof + 0.05}, 0.018);
    }
  } else {
    car.rod({back + slope + 0.1, 0.0, roof}, {back + slope - 0.15, 0.0, roof + 0.35}, 0.008);  // aerial
  }
}

void add_van(StreetSide& to, const Vector3d& at) {
  const bool is_white = to.chance(0.6);
  VehicleParts van(to, at, is_white ? Vector3d(0.86, 0.86, 0.85) : to.dice().pick(kVehicleTints));
  const double front = 2.5, rear = -2.5, half = 0.92, roof = 2.15;
  van.shade(rear, front, half);
  van.box(StreetMaterial::kVan, rear, 1.3, half, 0.32, roof);
  van.cut(StreetMaterial::kCarBody, 1.3, front, half, 0.32, 1.25, 1.75, 1.25, front, 0.9);
  van.cut(StreetMaterial::kCarCabin, 1.3, 2.0, half, 1.25, roof, 1.4, roof, 2.0, 1.25);
  van.tyres(1.7, -1.6, 0.33, half - 0.01);
  van.mirrors(1.55, half, 1.3);
  van.number_plates(front, rear, 0.5);
  van.box(StreetMaterial::kPainted, rear - 0.08, rear, half, 0.36, 0.50);
  if (to.chance(0.4)) {  // a ladder on its roof
    for (const double y : {-0.25, 0.2}) van.rod({-2.0, y, roof + 0.12}, {1.0, y, roof + 0.12}, 0.022);
    for (double x = -1.8; x < 1.0; x += 0.32) van.rod({x, -0.25, roof + 0.12}, {x, 0.2, roof + 0.12}, 0.014);
  }
}

void add_truck(StreetSide& to, const Vector3d& at) {
  VehicleParts truck(to, at, to.dice().pick(kVehicleTints));
  const double front = 2.75, rear = -2.75, half = 0.94;
  truck.shade(rear, front, half);
  truck.box(StreetMaterial::kCarBody, 1.25, front, half, 0.42, 1.2);
  truck.cut(StreetMaterial::kCarCabin, 1.25, front, half - 0.03, 1.2, 2.05, 2.35, 2.05, front, 1.2);
  truck.mirrors(2.4, half, 1.4);
  truck.number_plates(front, rear, 0.5);
  truck.tyres(1.9, -1.7, 0.38, half - 0.02);
  truck.paint({0.13, 0.13, 0.14});
  truck.box(StreetMaterial::kPainted, rear + 0.1, 1.25, 0.45, 0.45, 0.72);
  truck.box(StreetMaterial::kPainted, rear, rear + 0.08, half - 0.05, 0.42, 0.55);
  truck.paint(to.dice().pick(kVehicleTints) * 0.4 + Vector3d::Constant(0.5));
  truck.box(StreetMaterial::kVan, rear, 1.1, half, 0.74, 2.65);
}

}  // namespace

void add_detail_vehicle(StreetSide& to, const Vector3d& at, bool is_low) {
  const double kind = to.between(0.0, 1.0);
  // Keeps mirrors out of the driving lanes.
  const auto at_least = [&](double y) {
    return Vector3d(at.x(), to.side() * std::max(std::abs(at.y()), y), 0.0);
  };
  if (!is_low && kind < 0.20) return add_van(to, at_least(4.56));
  if (!is_low && kind < 0.32) return add_truck(to, at_least(4.56));
  add_passenger_car(to, at_least(4.50), kind > 0.72, kind > 0.3 && kind < 0.45);
}

}  // namespace simuli::bench
