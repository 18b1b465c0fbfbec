#include "bench/paper/seen.hpp"

#include <algorithm>
#include <cmath>

#include "host/core/base/parallel.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSeeFar_m = 2e4;         // as for the street's pictures
constexpr double kSameSurface_m = 0.002;  // maximum distance between two rays' points of one surface

/// Returns the solid angle of a pixel in sr.
double solid_angle(const Camera& camera, const Vector2d& pixel) {
  const auto along = [&](double x, double y) {
    return camera.unproject(pixel + Vector2d(x, y)).normalized();
  };
  return (along(0.5, 0.0) - along(-0.5, 0.0)).cross(along(0.0, 0.5) - along(0.0, -0.5)).norm();
}

/// Returns the area of a surface at `range_m` that a pixel covers, m².
double area(double solid_angle_sr, double range_m, double cosine) {
  return solid_angle_sr * range_m * range_m / std::max(std::abs(cosine), 1e-6);
}

}  // namespace

SeenBefore::SeenBefore(const TracedWorld& street, const std::optional<StreetCar>& car, const Log& log)
    : street_(street), car_(car) {
  for (const ImageFrame& image : log.images) {
    const LogCamera& camera = log.camera(image.camera);
    const double time_s = 0.5 * (image.time_start_s + image.time_end_s);
    pictures_.push_back({camera.model, log.world_from_rig.at(time_s) * camera.rig_from_camera, time_s});
  }
}

SeenBefore::Surface SeenBefore::place(const TracedWorld& street,
                                      const Picture& picture,
                                      const Vector2d& pixel) {
  const Vector3d origin = picture.world_from_camera.translation;
  const Vector3d direction =
      (picture.world_from_camera.rotation * picture.camera.unproject(pixel)).normalized();
  Surface out;
  out.hit = street.trace(origin, direction, picture.time_s, kSeeFar_m);
  out.time_s = picture.time_s;
  out.at = direction;
  if (!out.hit.hit) return out;
  out.at = origin + out.hit.range * direction;
  out.area_m2 = area(solid_angle(picture.camera, pixel), out.hit.range, out.hit.normal.dot(direction));
  return out;
}

std::optional<double> SeenBefore::share(const Picture& picture, const Surface& place) const {
  const Vector3d origin = picture.world_from_camera.translation;
  Vector3d at = place.at;
  if (place.hit.on_car && car_) at += car_->position(picture.time_s) - car_->position(place.time_s);
  const Vector3d way = place.hit.hit ? Vector3d(at - origin) : at;
  const Camera& camera = picture.camera;
  Vector2d pixel;
  if (!camera.project(picture.world_from_camera.rotation.conjugate() * way, pixel)) return std::nullopt;
  if (pixel.x() < 0.0 || pixel.x() >= camera.width || pixel.y() < 0.0 || pixel.y() >= camera.height) {
    return std::nullopt;
  }
  const double range_m = way.norm();
  const Vector3d direction = way / range_m;
  if (!place.hit.hit) {
    if (street_.trace(origin, direction, picture.time_s, kSeeFar_m).hit) return std::nullopt;
    return 1.0;
  }
  const StreetHit met = street_.trace(origin, direction, picture.time_s, range_m + kSameSurface_m);
  // The back side of a thin object is another surface.
  if (met.hit && (met.range < range_m - kSameSurface_m || met.normal.dot(place.hit.normal) <= 0.0)) {
    return std::nullopt;
  }
  return place.area_m2 / area(solid_angle(camera, pixel), range_m, place.hit.normal.dot(direction));
}

std::vector<Seen> SeenBefore::of(const LogCamera& camera,
                                 const Trajectory& world_from_rig,
                                 double time_start_s,
                                 double time_end_s) const {
  const double time_s = 0.5 * (time_start_s + time_end_s);
  const Picture here{camera.model, world_from_rig.at(time_s) * camera.rig_from_camera, time_s};
  const auto width = static_cast<std::size_t>(camera.model.width);
  std::vector<Seen> out(width * static_cast<std::size_t>(camera.model.height), Seen::kNever);
  parallel_each(
      out.size(),
      [&](std::size_t i) {
        const Vector2d pixel(static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5);
        const Surface shown = place(street_, here, pixel);
        for (const Picture& picture : pictures_) {
          const std::optional<double> found = share(picture, shown);
          if (found) out[i] = std::max(out[i], *found >= kLeastShare ? Seen::kWell : Seen::kCoarsely);
          if (out[i] == Seen::kWell) break;
        }
      },
      1024);
  return out;
}

void SeenErrors::add(const Image& rendered, const Image& truth, const std::vector<Seen>& seen) {
  Picture& picture = pictures_.emplace_back();
  const auto channels = static_cast<std::size_t>(truth.channels);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    double squares = 0.0;
    for (std::size_t c = channels * i; c < channels * (i + 1); ++c) {
      const double off = static_cast<double>(rendered.data[c]) - static_cast<double>(truth.data[c]);
      squares += off * off / static_cast<double>(channels);
    }
    Sum& sum = picture[static_cast<std::size_t>(seen[i])];
    ++sum.pixels, sum.squares += squares;
  }
}

SeenErrors::Sum SeenErrors::sum(Seen seen) const {
  Sum out;
  for (const Picture& picture : pictures_) {
    const Sum& own = picture[static_cast<std::size_t>(seen)];
    out.pixels += own.pixels, out.squares += own.squares;
  }
  return out;
}

double SeenErrors::share(Seen seen) const {
  std::size_t all = 0;
  for (const Seen each : {Seen::kNever, Seen::kCoarsely, Seen::kWell}) all += sum(each).pixels;
  return static_cast<double>(sum(seen).pixels) / static_cast<double>(std::max<std::size_t>(all, 1));
}

double SeenErrors::psnr_db(Seen seen) const {
  const Sum own = sum(seen);
  return -10.0 * std::log10(own.squares / static_cast<double>(std::max<std::size_t>(own.pixels, 1)));
}

double SeenErrors::psnr_of_seen_as_in_db(const SeenErrors& path) const {
  const auto of_seen = [](const Picture& picture) {
    const Sum &coarse = picture[static_cast<std::size_t>(Seen::kCoarsely)],
              &well = picture[static_cast<std::size_t>(Seen::kWell)];
    return Sum{coarse.pixels + well.pixels, coarse.squares + well.squares};
  };
  double total_db = 0.0;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const Sum taught = of_seen(path.pictures_.at(i)), seen = of_seen(pictures_[i]);
    const Sum& never = pictures_[i][static_cast<std::size_t>(Seen::kNever)];
    const double seen_squares = taught.squares / static_cast<double>(std::max<std::size_t>(taught.pixels, 1));
    const double squares = seen_squares * static_cast<double>(seen.pixels) + never.squares;
    total_db -= 10.0 * std::log10(squares / static_cast<double>(seen.pixels + never.pixels));
  }
  return total_db / static_cast<double>(pictures_.size());
}

}  // namespace simuli::bench
