#include "host/apps/cli/draw/sweep_canvas.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace simuli::cli {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Returns for each beam the mean offset of its azimuths along the spin, in columns.
std::vector<double> shifts_of(const Lidar& lidar, const LidarRays& rays, int columns) {
  const double step = lidar.azimuth_span / columns;
  std::vector<double> shifts;
  for (std::size_t row = 0; row < lidar.rows.size(); ++row) {
    double sine = 0.0, cosine = 0.0;
    for (int column = 0; column < columns; ++column) {
      const auto azimuth = static_cast<double>(
          rays.azimuth[row * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)]);
      const double off = lidar.spin_sign() * (azimuth - lidar.azimuth_first) - step * column;
      sine += std::sin(off);
      cosine += std::cos(off);
    }
    shifts.push_back(std::atan2(sine, cosine) / step);
  }
  return shifts;
}

/// Returns the width of a column in pixels: 2 if offsets relative to the first beam are not whole columns.
int column_px(const std::vector<double>& shifts, int columns) {
  constexpr double kOff = 0.15;  // of a column
  const bool is_right = std::all_of(shifts.begin(), shifts.end(), [&](double shift) {
    const double beside = shift - shifts.front();
    return std::abs(beside - std::round(beside)) <= kOff;
  });
  return is_right || 2 * columns > SweepCanvas::kWidest_px ? 1 : 2;
}

}  // namespace

SweepCanvas::SweepCanvas(const LidarModel& lidar, const LidarRays& rays) {
  const auto* const rows = std::get_if<Lidar>(&lidar);
  if (rows != nullptr) {
    place_rows(*rows, rays);
  } else {
    place_list(rays);
  }
  for (std::size_t i = 0; i < image_.data.size(); ++i) image_.data[i] = kNoRay[i % 3];
}

void SweepCanvas::place_rows(const Lidar& lidar, const LidarRays& rays) {
  const int columns = static_cast<int>(rays.azimuth.size() / lidar.rows.size());
  const std::vector<double> shifts = shifts_of(lidar, rays, columns);
  ray_width_ = column_px(shifts, columns);
  ray_height_ = kBeam_px * ray_width_;
  const int first_px = ray_width_ * static_cast<int>(std::lround(shifts.front()));
  std::vector<int> shifts_px;
  for (const double shift : shifts) {
    shifts_px.push_back(first_px + static_cast<int>(std::lround(ray_width_ * (shift - shifts.front()))));
  }
  const auto [least, most] = std::minmax_element(shifts_px.begin(), shifts_px.end());
  const int sweep_px = columns * ray_width_;
  const bool is_turn = std::abs(lidar.azimuth_span / kTurn_rad - 1.0) * columns < 0.5;
  image_ = Image(is_turn ? sweep_px : sweep_px + *most - *least, lidar.row_count() * ray_height_, 3);
  for (int row = 0; row < lidar.row_count(); ++row) {
    const int shift_px = shifts_px[static_cast<std::size_t>(row)];
    for (int column = 0; column < columns; ++column) {
      const int along = column * ray_width_ + shift_px;
      const int from_left = is_turn ? (along % sweep_px + sweep_px) % sweep_px : along - *least;
      // Azimuth increases to the left.
      const bool is_clockwise = lidar.spin == SpinDirection::kClockwise;
      places_.push_back(
          {is_clockwise ? from_left : image_.width - ray_width_ - from_left, row * ray_height_});
    }
  }
}

void SweepCanvas::place_list(const LidarRays& rays) {
  constexpr double kPixels = kListRay_px * kListRay_px;
  constexpr double kNarrowest_rad = 1e-3;
  double sine = 0.0, cosine = 0.0;
  for (const float azimuth : rays.azimuth) {
    sine += std::sin(static_cast<double>(azimuth));
    cosine += std::cos(static_cast<double>(azimuth));
  }
  const double middle = std::atan2(sine, cosine);
  std::vector<double> left, up;  // rad, relative to the centre
  for (std::size_t i = 0; i < rays.azimuth.size(); ++i) {
    left.push_back(std::remainder(static_cast<double>(rays.azimuth[i]) - middle, kTurn_rad));
    up.push_back(static_cast<double>(rays.elevation[i]));
  }
  const auto [right_end, left_end] = std::minmax_element(left.begin(), left.end());
  const auto [low_end, high_end] = std::minmax_element(up.begin(), up.end());
  const double width = std::max(*left_end - *right_end, kNarrowest_rad);
  const double height = std::max(*high_end - *low_end, kNarrowest_rad);
  const double px_per_rad =
      std::min(std::sqrt(kPixels * static_cast<double>(rays.azimuth.size()) / (width * height)),
               kWidest_px / std::max(width, height));
  const auto pixels = [px_per_rad](double angle) { return static_cast<int>(angle * px_per_rad); };
  image_ = Image(pixels(width) + kListRay_px, pixels(height) + kListRay_px, 3);
  for (std::size_t i = 0; i < left.size(); ++i) {
    places_.push_back({pixels(*left_end - left[i]), pixels(*high_end - up[i])});
  }
}

void SweepCanvas::draw(std::size_t ray, const std::array<float, 3>& colour) {
  const Place& place = places_[ray];
  for (int dx = 0; dx < ray_width_; ++dx) {
    const int x = (place.x + dx + image_.width) % image_.width;  // wraps around
    for (int dy = 0; dy < ray_height_; ++dy) {
      for (int c = 0; c < 3; ++c) image_.at(x, place.y + dy, c) = colour[static_cast<std::size_t>(c)];
    }
  }
}

}  // namespace simuli::cli
