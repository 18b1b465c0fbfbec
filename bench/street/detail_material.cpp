// Surfaces of the detailed street's furniture, leaves and vehicles.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "bench/street/detail.hpp"
#include "bench/street/detail_pattern.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;
using street_pattern::cell;
using street_pattern::ease;
using street_pattern::fine;
using street_pattern::glass;
using street_pattern::hash;
using street_pattern::ink;
using street_pattern::noise;
using street_pattern::patches;
using street_pattern::scaled;
using street_pattern::wrap;

constexpr std::array<std::string_view, 12> kWords{
    "CAFE", "BROT", "BIKES", "PIZZA", "BUCH", "HOTEL", "KIOSK", "MUSIC", "SUSHI", "TEA 8", "OPTIK", "SALON"};

constexpr double kTwoPi = 2.0 * 3.14159265358979;

/// Returns the reading position in [0, 1) on a face, to the right of a viewer.
double read_along(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  if (std::abs(normal.y()) > 0.5) {
    const double u = (p.x() - s.low.x()) / (s.high.x() - s.low.x());
    return normal.y() > 0.0 ? 1.0 - u : u;
  }
  const double u = (p.y() - s.low.y()) / (s.high.y() - s.low.y());
  return normal.x() > 0.0 ? u : 1.0 - u;
}

StreetSurface lettering(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  if (std::abs(normal.z()) > 0.5) return scaled(s.tint, 0.35, 0.8);
  const std::string_view word = kWords[s.style % kWords.size()];
  const double wide = std::abs(normal.y()) > 0.5 ? s.high.x() - s.low.x() : s.high.y() - s.low.y();
  const double tall = s.high.z() - s.low.z();
  const double v = (p.z() - s.low.z()) / tall, across = read_along(s, p, normal) * wide;
  const bool is_rim = v < 0.07 || v > 0.93;
  const double bright = s.tint.mean() > 0.45 ? 0.12 : 0.92;
  if (is_rim) return scaled(0.6 * s.tint + Vector3d::Constant(0.25), 0.4, 1.0);
  const double letter = std::min(0.62 * tall, 0.9 * wide / static_cast<double>(word.size()));
  const double text = letter * static_cast<double>(word.size());
  const double up = (p.z() - s.low.z() - 0.5 * (tall - letter * 1.25)) / (letter * 1.25);
  if (ink(word, (across - 0.5 * (wide - text)) / letter, up))
    return scaled(Vector3d::Constant(bright), 0.6, 1.0);
  return scaled(s.tint, s.reflectance, 0.95 + 0.1 * v);
}

StreetSurface poster(const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed) {
  if (std::abs(normal.z()) > 0.5) return scaled(s.tint, s.reflectance, 0.8);
  const bool is_round = s.shape == meet_pole;
  const double tall = s.high.z() - s.low.z(), v = (p.z() - s.low.z()) / tall;
  double u = 0.0, wide = 0.0;
  if (is_round) {
    wide = kTwoPi * s.radius;
    u = wrap(std::atan2(normal.y(), normal.x()) / kTwoPi, 1.0);
  } else {
    wide = std::abs(normal.y()) > 0.5 ? s.high.x() - s.low.x() : s.high.y() - s.low.y();
    u = read_along(s, p, normal);
  }
  // Sheets of about 0.6 m x 0.9 m in a frame.
  const double columns = std::max(1.0, std::floor(wide / 0.55)),
               rows = std::max(1.0, std::floor(tall / 0.85));
  const double a = wrap(u * columns, 1.0), b = wrap(v * rows, 1.0);
  const auto i = cell(u * columns), j = cell(v * rows);
  if (a < 0.06 || a > 0.94 || b < 0.05 || b > 0.95) return scaled(s.tint, s.reflectance, 1.0);
  const auto dice = [&](std::int64_t k) { return hash(i + 8 * j, s.style, k, seed + 71); };
  const Vector3d paper(0.35 + 0.6 * dice(0), 0.3 + 0.6 * dice(1), 0.25 + 0.6 * dice(2));
  const Vector3d other(0.9 - 0.7 * dice(3), 0.85 - 0.7 * dice(4), 0.9 - 0.7 * dice(5));
  if (std::hypot(a - 0.3 - 0.4 * dice(6), (b - 0.62) * 1.5) < 0.16 + 0.14 * dice(7))
    return scaled(other, 0.5, 1.0);
  if (b > 0.12 && b < 0.30 &&
      ink(kWords[static_cast<std::size_t>(12.0 * dice(8))], (a - 0.1) * 6.0, (b - 0.12) / 0.18))
    return scaled(Vector3d::Constant(paper.mean() > 0.5 ? 0.1 : 0.92), 0.5, 1.0);
  return scaled(paper, 0.5, 1.0 + 0.15 * noise({3.0 * a, 3.0 * b, dice(9) * 50.0}, seed));
}

/// Returns the surface of a road sign, whose kind follows from its number of sides.
StreetSurface plate(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  const double face = s.tint.x();  // sign of the face's normal
  if (normal.x() * face < 0.0) return scaled({0.55, 0.56, 0.57}, 0.4, 1.0);
  const double a = (p.y() - s.centre.y()) * (face < 0.0 ? -1.0 : 1.0) / s.radius,
               b = (p.z() - s.centre.z()) / s.radius;
  const double r = std::hypot(a, b);
  const Vector3d white(0.93, 0.93, 0.92), red(0.80, 0.08, 0.08), blue(0.08, 0.26, 0.62),
      dark(0.08, 0.08, 0.09);
  const auto colour = [&]() -> Vector3d {
    const std::uint32_t kind = (s.style - 1) % 8;
    if (kind == 0) {  // speed limit
      if (r > 0.76) return red;
      return ink("50", (a + 0.62) / 0.62, (b + 0.45) / 0.9) ? dark : white;
    }
    if (kind == 1) {  // no stopping
      if (r > 0.80 || std::abs(a - b) < 0.2) return red;
      return blue;
    }
    if (kind == 2) {  // warning
      const double out = std::max({-b, 0.5 * b + 0.866 * a, 0.5 * b - 0.866 * a});
      if (out > 0.66) return red;
      return std::abs(a) < 0.14 && b > -0.35 && b < 0.9 && std::abs(b + 0.1) > 0.1 ? dark : white;
    }
    if (kind == 3) {  // parking
      if (std::max(std::abs(a), std::abs(b)) > 0.9) return white;
      return ink("P", (a + 0.45) / 1.2, (b + 0.7) / 1.4) ? white : blue;
    }
    if (r > 0.93) return white;
    return ink("STOP", (a + 0.8) / 0.42, (b + 0.3) / 0.6) ? white : red;
  };
  return scaled(colour(), 0.9, 1.0);
}

StreetSurface signal(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  const double face = s.style == 1 ? -1.0 : 1.0;
  if (normal.x() * face < 0.5) return scaled({0.10, 0.10, 0.11}, 0.2, 1.0);
  const double v = (p.z() - s.low.z()) / (s.high.z() - s.low.z()) * 3.0,
               across = p.y() - 0.5 * (s.low.y() + s.high.y());
  const double r = std::hypot(across, (wrap(v, 1.0) - 0.5) * 0.316);
  if (r > 0.115) return scaled({0.12, 0.12, 0.13}, 0.2, 1.0);
  const auto lamp = cell(v);
  if (lamp == 0) return scaled({0.10, 0.85, 0.45}, 0.6, 1.0);
  return scaled(lamp == 1 ? Vector3d(0.36, 0.26, 0.06) : Vector3d(0.34, 0.07, 0.06), 0.4, 1.0);
}

StreetSurface striped(const StreetSolid& s, const Vector3d& p) {
  const double up = p.z() - s.low.z();
  if (s.style == 2) {  // an awning with vertical stripes
    return wrap(p.x(), 0.5) < 0.25 ? scaled(s.tint, 0.4, 1.0) : scaled({0.88, 0.86, 0.80}, 0.5, 1.0);
  }
  if (s.style == 3)
    return wrap(up, 0.3) < 0.15 ? scaled(s.tint, 0.6, 1.0) : scaled({0.9, 0.9, 0.9}, 0.9, 1.0);
  return up > 0.68 && up < 0.82 ? scaled({0.9, 0.9, 0.9}, 0.95, 1.0) : scaled(s.tint, s.reflectance, 1.0);
}

StreetSurface slatted(const StreetSolid& s, const Vector3d& p, double footprint_m) {
  const double at =
      s.shape == meet_pole ? std::atan2(p.y() - s.centre.y(), p.x() - s.centre.x()) * s.radius : p.z();
  return scaled(s.tint, s.reflectance, 1.0 + 0.3 * fine(0.05, footprint_m) * std::sin(kTwoPi * at / 0.1));
}

/// Returns the surface of a bay window or dormer.
StreetSurface bay_window(const StreetSolid& s, const Vector3d& p, const Vector3d& normal) {
  if (std::abs(normal.z()) > 0.5) return scaled({0.45, 0.46, 0.48}, 0.35, 1.0);
  const bool faces_street = std::abs(normal.y()) > 0.5;
  const double low = faces_street ? s.low.x() : s.low.y(), high = faces_street ? s.high.x() : s.high.y();
  const double u = (faces_street ? p.x() : p.y()) - low, wide = high - low, up = p.z() - s.low.z();
  const double tall = s.high.z() - s.low.z();
  const double foot = tall > 2.0 ? 0.7 : 0.2;
  if (u < 0.12 || u > wide - 0.12 || up < foot || up > tall - 0.2) return scaled(s.tint, s.reflectance, 1.0);
  const double pane = wide > 1.0 ? 0.5 * (wide - 0.24) : wide - 0.24;
  const double at = wrap(u - 0.12, pane);
  if (at < 0.04 || at > pane - 0.04 || std::abs(up - tall + 0.7) < 0.03)
    return scaled({0.9, 0.89, 0.86}, 0.5, 1.0);
  return glass(0.6 + 0.4 * (up - foot));
}

StreetSurface roof(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  if (normal.z() < 0.2) return scaled({0.62, 0.55, 0.48}, 0.3, 1.0 + 0.1 * patches(p, 1.5, seed));
  const auto row = cell(p.z(), 0.16);
  const double tile = hash(cell(p.x() + 0.13 * static_cast<double>(row & 1), 0.26), row, 0, seed + 81);
  const double shade =
      fine(0.13, footprint_m) * (0.4 * (tile - 0.5) + 0.3 * (0.5 - wrap(p.z(), 0.16) / 0.16));
  return scaled(s.tint, s.reflectance, 1.0 + shade + 0.15 * patches(p, 2.0, seed + 82));
}

StreetSurface leaves(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  // Lower and inner leaves of a clump are in the shade of upper ones.
  const double depth = 0.75 + 0.3 * normal.z();
  const double texture =
      0.35 * fine(0.09, footprint_m) * noise(p / 0.09, seed + 91) + 0.15 * noise(p / 0.3, seed + 92);
  return scaled(s.tint, s.reflectance, depth * (1.0 + texture));
}

}  // namespace

StreetSurface detail_vehicle(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  // In the vehicle's frame, x forward.
  const double forward = (s.style & 2U) != 0 ? -1.0 : 1.0;
  const auto own = static_cast<std::int64_t>(s.style);
  Vector3d q = p - s.centre, n = normal;
  q.head<2>() *= forward;
  n.head<2>() *= forward;
  const double front = forward > 0.0 ? s.high.x() - s.centre.x() : s.centre.x() - s.low.x();
  const double rear = forward > 0.0 ? s.low.x() - s.centre.x() : s.centre.x() - s.high.x();
  const double dust =
      1.0 - 0.22 * (1.0 - ease(0.25, 0.75, q.z())) * (0.8 + 0.4 * noise(q / 0.3, seed + s.style));
  const auto line = [&](double at, double where) {
    return fine(0.035, footprint_m) * (1.0 - ease(0.006, 0.022, std::abs(at - where)));
  };
  switch (s.material) {
    case StreetMaterial::kNumberPlate: {
      if (std::abs(n.x()) < 0.5) return scaled({0.2, 0.2, 0.2}, 0.3, 1.0);
      const double u = (q.y() * (n.x() > 0.0 ? 1.0 : -1.0) + 0.26) / 0.52, v = (p.z() - s.low.z()) / 0.12;
      if (u < 0.08) return scaled({0.10, 0.22, 0.60}, 0.9, 1.0);
      constexpr std::string_view kSigns = "ABCEHKLMNOPRSTU0123456789";
      const double letter = (u - 0.1) / 0.9 * 7.0;
      const double drawn = hash(cell(letter), own, 0, seed + 95);
      const std::string_view sign = kSigns.substr(static_cast<std::size_t>(25.0 * drawn), 1);
      const bool is_dark = ink(sign, letter - std::floor(letter), (v - 0.15) / 0.7);
      return scaled({0.9, 0.9, 0.88}, 0.95, is_dark ? 0.15 : 1.0);
    }
    case StreetMaterial::kVan: {
      // The sides have a name and a stripe, the rear two doors.
      const double wide = s.high.x() - s.low.x(), tall = s.high.z() - s.low.z(),
                   v = (p.z() - s.low.z()) / tall;
      if (std::abs(n.y()) > 0.5) {
        const double u = read_along(s, p, normal);
        const Vector3d livery(0.2 + 0.6 * hash(own, 1, 0, seed),
                              0.15 + 0.5 * hash(own, 2, 0, seed),
                              0.25 + 0.5 * hash(own, 3, 0, seed));
        const double letter = std::min(0.35 * tall, 0.13 * wide);
        if (ink(kWords[s.style / 4 % kWords.size()],
                (u - 0.18) * wide / letter,
                (v - 0.52) * tall / (1.2 * letter)))
          return scaled(livery, 0.5, 1.0);
        if (std::abs(v - 0.36 - 0.1 * (u - 0.5)) < 0.05) return scaled(livery, 0.5, 1.0);
        const double wheel =
            std::min(std::hypot(q.x() + 1.6, q.z() - 0.34), std::hypot(q.x() - 1.7, q.z() - 0.34));
        if (wheel < 0.40 && p.z() < 0.74) return scaled({0.05, 0.05, 0.06}, 0.05, 1.0);
        const double seam = std::max(line(u, 0.5 + 0.2 * forward), line(q.z(), s.low.z() + 0.3));
        return scaled(s.tint, s.reflectance, dust * (1.0 - 0.5 * seam));
      }
      if (n.x() < -0.5) {
        const bool is_lamp = std::abs(q.y()) > 0.72 && v > 0.25 && v < 0.5;
        if (is_lamp) return scaled({0.75, 0.10, 0.07}, 0.9, 1.0);
        const bool is_window =
            tall < 1.9 && v > 0.6 && v < 0.9 && std::abs(q.y()) > 0.1 && std::abs(q.y()) < 0.7;
        if (is_window) return glass(0.7);
        return scaled(s.tint, s.reflectance, dust * (1.0 - 0.6 * line(q.y(), 0.0)));
      }
      return scaled(s.tint, s.reflectance, 1.0 + 0.06 * patches(q, 0.8, seed));
    }
    case StreetMaterial::kCarCabin: {
      const bool is_side = std::abs(n.y()) > 0.5;
      const double low = s.low.z(), high = s.high.z();
      if (n.z() > 0.9) return scaled(s.tint, s.reflectance, 1.0);
      const double edge = std::abs(q.y()) - (0.5 * (s.high.y() - s.low.y()) - 0.09);
      const bool is_rail = q.z() > high - 0.08 || q.z() < low + 0.05;
      const bool is_pillar =
          is_side ? std::abs(q.x() - front) < 0.07 || std::abs(q.x() - rear) < 0.07 : edge > 0.0;
      if (is_rail || is_pillar) return scaled(s.tint, s.reflectance, 0.85);
      const double z = (q.z() - low) / (high - low);
      if (!is_side && n.x() > 0.3 && q.y() < -0.35 && q.y() > -0.55 && z < 0.3) {  // stickers
        return {hash(own, 5, 0, seed) < 0.5 ? Vector3d(0.75, 0.70, 0.20) : Vector3d(0.25, 0.62, 0.35), 0.0};
      }
      const bool has_rest = z < 0.5 && (is_side ? std::abs(wrap(q.x() + 0.2, 0.9) - 0.45) < 0.1
                                                : std::abs(std::abs(q.y()) - 0.36) < 0.12);
      return has_rest ? StreetSurface{Vector3d(0.09, 0.09, 0.10), 0.0} : glass(0.45 + 0.8 * z);
    }
    default: {
      if (std::abs(n.y()) > 0.5) {
        const double length = front - rear;
        const double ahead = length > 3.0 || s.shape == meet_cut ? 1.3 : 1.9;
        const double wheel =
            std::min(std::hypot(q.x() - ahead, q.z() - 0.32), std::hypot(q.x() + 1.3, q.z() - 0.32));
        if (wheel < 0.20) {
          const double spokes = std::cos(5.0 * std::atan2(q.z() - 0.32, wrap(q.x(), 2.6) - 1.3));
          return scaled(
              {0.52, 0.53, 0.55}, 0.4, 1.0 + 0.5 * fine(0.1, footprint_m) * spokes * ease(0.03, 0.1, wheel));
        }
        if (wheel < 0.34) return scaled({0.06, 0.06, 0.07}, 0.05, 1.0);
        if (q.z() > 0.74 && q.z() < 0.79 && std::abs(q.x() + 0.15) < 0.1)
          return scaled(Vector3d::Constant(0.12), 0.2, 1.0);  // a handle
        double seam = std::max({line(q.x(), 0.85), line(q.x(), -0.28), line(q.x(), -1.15)});
        if (q.z() < 0.36) seam = 0.0;
        seam = std::max(seam, 0.6 * line(q.z(), 0.58));
        return scaled(s.tint, s.reflectance, dust * (0.85 + 0.25 * (q.z() - 0.26)) * (1.0 - 0.6 * seam));
      }
      if (std::abs(n.x()) > 0.5) {
        const bool is_lamp = std::abs(q.y()) > 0.55 && q.z() > 0.55 && q.z() < 0.80;
        if (is_lamp && n.x() < 0.0)
          return scaled({0.80, 0.08, 0.06}, 0.9, std::abs(q.z() - 0.66) < 0.04 ? 1.3 : 0.9);
        if (is_lamp)
          return scaled(
              {0.95, 0.95, 0.88}, 0.9, std::hypot(std::abs(q.y()) - 0.68, q.z() - 0.67) < 0.07 ? 1.0 : 0.7);
        if (n.x() > 0.0 && std::abs(q.y()) < 0.5 && q.z() > 0.46 && q.z() < 0.70) {  // the grille
          return scaled({0.10, 0.10, 0.11},
                        0.15,
                        1.0 + 0.5 * fine(0.04, footprint_m) * std::sin(kTwoPi * q.z() / 0.08));
        }
        return scaled(s.tint, s.reflectance, dust * (1.0 - 0.5 * line(q.z(), 0.86)));
      }
      // The bonnet's edges.
      const double seam = std::max(line(std::abs(q.y()), 0.72), line(q.x(), front - 0.08));
      return scaled(s.tint, s.reflectance, 1.0 - 0.4 * seam + 0.04 * patches(q, 0.8, seed));
    }
  }
}

StreetSurface detail_surface(
    const StreetSolid& s, const Vector3d& p, const Vector3d& normal, std::uint64_t seed, double footprint_m) {
  switch (s.material) {
    case StreetMaterial::kAsphalt:
      return detail_road(s, p, seed, footprint_m);
    case StreetMaterial::kPavement:
      return detail_pavement(s, p, normal, seed, footprint_m);
    case StreetMaterial::kFacade:
      return detail_facade(s, p, normal, seed, footprint_m);
    case StreetMaterial::kCarBody:
    case StreetMaterial::kCarCabin:
    case StreetMaterial::kVan:
    case StreetMaterial::kNumberPlate:
      return detail_vehicle(s, p, normal, seed, footprint_m);
    case StreetMaterial::kBark: {
      const Vector3d drawn(p.x() / 0.06, p.y() / 0.06, p.z() / 0.35);
      const double furrows = 0.3 * fine(0.06, footprint_m) * noise(drawn, seed + 93);
      return scaled(s.tint, s.reflectance, 1.0 + 0.2 * noise(p * 3.0, seed) + furrows);
    }
    case StreetMaterial::kLeaves:
      return leaves(s, p, normal, seed, footprint_m);
    case StreetMaterial::kStone: {
      const double rows =
          s.style == 2 ? 0.2 * fine(0.08, footprint_m) * std::sin(kTwoPi * p.z() / 0.16) : 0.0;
      return scaled(s.tint, s.reflectance, 1.0 + rows + 0.12 * patches(p, 0.9, seed + 94));
    }
    case StreetMaterial::kShade:
      return scaled(s.tint,
                    s.reflectance,
                    s.style == 2 ? 1.0 + 0.3 * patches(p, 0.4, seed) : 0.45 + 0.06 * patches(p, 1.0, seed));
    case StreetMaterial::kStriped:
      return striped(s, p);
    case StreetMaterial::kSlatted:
      return slatted(s, p, footprint_m);
    case StreetMaterial::kPoster:
      return poster(s, p, normal, seed);
    case StreetMaterial::kPlate:
      return plate(s, p, normal);
    case StreetMaterial::kSignal:
      return signal(s, p, normal);
    case StreetMaterial::kLettering:
      return lettering(s, p, normal);
    case StreetMaterial::kRoof:
      return roof(s, p, normal, seed, footprint_m);
    case StreetMaterial::kBay:
      return bay_window(s, p, normal);
    case StreetMaterial::kPainted:
      return scaled(s.tint, s.reflectance, 1.0);
    case StreetMaterial::kTyre:
    case StreetMaterial::kMetal:
    case StreetMaterial::kSign:
      break;
  }
  return street_surface(s, p, normal, seed);
}

}  // namespace simuli::bench
