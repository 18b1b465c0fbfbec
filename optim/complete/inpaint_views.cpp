#include "optim/complete/inpaint_views.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "host/core/base/parallel.hpp"
#include "host/core/scene/placement.hpp"
#include "optim/base/evenly_spread.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

constexpr float kSolidTransmittance = 0.5F;
constexpr float kFarthest_m = 150.0F;    // beyond it parallax is negligible
constexpr double kWholeTurn_rad = 6.28;  // tolerance for a rounded azimuth span
constexpr double kAround_rad = 0.1;      // next to a gap: objects only there do not continue behind it
constexpr double kAround_m = 0.2;        // margin around an actor's box that still shows it
constexpr int kCameraEdge_px = 2, kLidarEdge = 1;

/// Returns the same particles with a uniform appearance, so that no colour is clipped.
GaussianSet of_one_look(const GaussianSet& set) {
  GaussianSet out(set.kind, 0, set.size());
  out.params.leftCols(kShRow) = set.params.leftCols(kShRow);
  return out;
}

double columns_per_rad(const Sensor& sensor) {
  if (sensor.is_camera()) return sensor.camera().focal_px();
  const auto* const spinning = std::get_if<Lidar>(&sensor.lidar());
  return spinning == nullptr ? 0.0 : spinning->columns / spinning->azimuth_span;
}

/// Whether a row of a sensor's rays covers the full revolution.
bool is_closed(const Sensor& sensor) {
  if (sensor.is_camera()) return false;
  const auto* const spinning = std::get_if<Lidar>(&sensor.lidar());
  return spinning != nullptr && spinning->azimuth_span > kWholeTurn_rad;
}

/// Adds weights times the appearance of particles from `eye`, in the set's frame.
void add_observations(const GaussianSet& set,
                      const Eigen::Vector3d& eye,
                      const Eigen::VectorXf& weights,
                      Eigen::MatrixX3f& observations) {
  const int coefficients = sh_coefficients(set.sh_degree);
  parallel_each(static_cast<std::size_t>(set.size()), [&](std::size_t particle) {
    const auto i = static_cast<Eigen::Index>(particle);
    if (!(weights(i) > 0.0F)) return;
    const Eigen::Vector3d towards = set.mean().row(i).transpose().cast<double>() - eye;
    const Eigen::RowVectorXf basis = sh_basis_at(towards.normalized()).cast<float>();
    Eigen::RowVector3f look = Eigen::RowVector3f::Zero();
    for (int k = 0; k < coefficients; ++k) look += basis(k) * set.sh(k).row(i);
    observations.row(i) += weights(i) * look;
  });
}

}  // namespace

InpaintSensor::InpaintSensor(Sensor of) : sensor(std::move(of)) {
  const std::size_t rays = sensor.ray_count(), columns = sensor.columns();
  origin.assign(rays, Eigen::Vector3f::Zero());
  direction.assign(rays, Eigen::Vector3f::Zero());
  share.assign(rays, 0.0F);
  parallel_each(rays, [&](std::size_t i) {
    if (sensor.is_camera()) {
      const Camera& camera = sensor.camera();
      const Eigen::Vector2d pixel(static_cast<double>(i % columns) + 0.5,
                                  static_cast<double>(i / columns) + 0.5);
      const Eigen::Vector3d out = camera.unproject(pixel);
      if (out.squaredNorm() > 0.0) direction[i] = out.normalized().cast<float>();
      share[i] = static_cast<float>(camera.exposure_fraction(pixel));
    } else {
      const LidarRays& own = sensor.rays();
      direction[i] =
          Lidar::direction(static_cast<double>(own.azimuth[i]), static_cast<double>(own.elevation[i]))
              .cast<float>();
      origin[i] = ray_origin(sensor.lidar(), own, i).cast<float>();
      share[i] = own.time_fraction[i];
    }
  });
}

void InpaintView::ray(std::size_t index, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const {
  const Pose world_from_sensor = shot.pose_at(static_cast<double>(on->share[index]));
  origin = world_from_sensor * on->origin[index].cast<double>();
  direction = world_from_sensor.rotation * on->direction[index].cast<double>();
}

BoxInterval ActorBox::inside(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  return inside_box(actor_from_world * origin, actor_from_world.rotation * direction, half_m);
}

bool ActorBox::holds(const Eigen::Vector3d& p_world) const {
  constexpr double kRounding = 1.0 + 1e-6;  // margin of the bounding ball, which rejects most points cheaply
  if ((p_world - center_world).squaredNorm() > kRounding * half_m.squaredNorm()) return false;
  return ((actor_from_world * p_world).array().abs() <= half_m.array()).all();
}

std::vector<ActorBox> boxes_in(const Scene& scene, const InpaintView& view, double margin_m) {
  std::vector<ActorBox> boxes;
  const double middle_s = view.shot.middle_s();
  for (std::size_t a = 0; a < scene.actors.size(); ++a) {
    const Actor& actor = scene.actors[a];
    if (!actor.is_there(middle_s)) continue;
    const Pose world_from_actor = actor.at(middle_s);
    boxes.push_back({static_cast<std::uint32_t>(a + 1),
                     world_from_actor.inverse(),
                     world_from_actor.translation,
                     0.5 * actor.size_m + Eigen::Vector3d::Constant(margin_m)});
  }
  return boxes;
}

ActorsBefore::ActorsBefore(const std::vector<std::uint32_t>& of_rays) {
  std::uint32_t last = 0;
  for (std::size_t ray = 0; ray < of_rays.size(); ++ray) {
    if (of_rays[ray] != last) changes_.push_back({ray, of_rays[ray]});
    last = of_rays[ray];
  }
}

std::vector<std::uint32_t> ActorsBefore::of(std::size_t rays) const {
  std::vector<std::uint32_t> out(rays, 0);
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    const std::size_t end = i + 1 < changes_.size() ? changes_[i + 1].ray : rays;
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(changes_[i].ray),
              out.begin() + static_cast<std::ptrdiff_t>(end),
              changes_[i].actor);
  }
  return out;
}

std::vector<InpaintView> inpaint_views(const Log& log,
                                       const FrameSelection& frames,
                                       SetKind kind,
                                       std::size_t most) {
  const HeldOutRule rule(log, frames);
  std::vector<InpaintView> views;
  if (kind == SetKind::kCamera) {
    const std::vector<std::size_t> training = rule.training(log.images);
    for (const LogCamera& camera : log.cameras) {
      const std::string& name = camera.model.name;
      const double pixels = static_cast<double>(camera.model.width) * camera.model.height;
      const double scale = std::min(frames.image_scale, std::sqrt(kMostPixels / pixels));
      const auto sensor = std::make_shared<const InpaintSensor>(
          Sensor(scaled_camera(camera.model, scale), camera.rig_from_camera));
      const auto is_own = [&](const ImageFrame& frame) { return frame.camera == name; };
      for (const std::size_t i : evenly_spread(own_of(training, log.images, is_own), most)) {
        views.push_back({sensor, shot_of(log, log.images[i])});
      }
    }
    return views;
  }
  const std::vector<std::size_t> training = rule.training(log.sweeps);
  for (const LogLidar& lidar : log.lidars) {
    const std::string& name = name_of(lidar.model);
    Sensor of(lidar.model, lidar.rig_from_lidar);
    if (of.rows() < 2) continue;
    const auto sensor = std::make_shared<const InpaintSensor>(std::move(of));
    const auto is_own = [&](const SweepFrame& frame) { return frame.lidar == name; };
    for (const std::size_t i : evenly_spread(own_of(training, log.sweeps, is_own), most)) {
      views.push_back({sensor, shot_of(log, log.sweeps[i])});
    }
  }
  return views;
}

ActorsBefore actors_before(SceneOnDevice& scene, const InpaintView& view) {
  const Frame frame = scene.render(view.sensor(), view.shot, {.graded = false, .actors = true});
  RayRows rows;
  rows.rows = view.sensor().rows(), rows.columns = view.sensor().columns();
  rows.closed = is_closed(view.sensor());
  rows.actor = frame.owners();
  const std::vector<ActorBox> boxes = boxes_in(scene.scene(), view, kAround_m);
  const RayResults& seen = frame.results();
  // Background particles that training placed next to an actor to show its silhouette.
  parallel_each(rows.rays(), [&](std::size_t ray) {
    if (rows.actor[ray] != 0 || !(seen.transmittance[ray] < kSolidTransmittance)) return;
    Eigen::Vector3d origin, direction;
    view.ray(ray, origin, direction);
    const Eigen::Vector3d met = origin + static_cast<double>(seen.expected_distance(ray)) * direction;
    for (const ActorBox& box : boxes) {
      if (box.holds(met)) rows.actor[ray] = box.actor;
    }
  });
  widen_actors(rows, view.sensor().is_camera() ? kCameraEdge_px : kLidarEdge);
  return ActorsBefore(rows.actor);
}

RayRows rows_of(SceneOnDevice& background, const InpaintView& view, const ActorsBefore& actors) {
  const Frame frame = background.render(view.sensor(), view.shot, {.graded = false});
  const RayResults& seen = frame.results();
  RayRows out;
  out.rows = view.sensor().rows(), out.columns = view.sensor().columns();
  out.closed = is_closed(view.sensor());
  out.around = static_cast<std::size_t>(kAround_rad * columns_per_rad(view.sensor()));
  out.actor = actors.of(out.rays());
  for (std::size_t ray = 0; ray < out.rays(); ++ray) {
    const float range_m = seen.transmittance[ray] < kSolidTransmittance ? seen.expected_distance(ray) : 0.0F;
    out.range_m.push_back(range_m > kFarthest_m ? std::numeric_limits<float>::infinity() : range_m);
    out.features.push_back({seen.feature[0][ray], seen.feature[1][ray], seen.feature[2][ray]});
  }
  return out;
}

SeenWeights seen_weights(const Device& device,
                         const GaussianSet& background,
                         const std::vector<InpaintView>& views,
                         const std::vector<ActorsBefore>& actors,
                         const Eigen::Vector3d& origin,
                         const RenderOptions& render) {
  Scene probe;
  probe.origin = origin;
  const bool is_camera = background.kind == SetKind::kCamera;
  (is_camera ? probe.camera : probe.lidar) = of_one_look(background);
  SceneOnDevice on_device(device, std::move(probe), render);
  SeenWeights out{Eigen::VectorXf::Zero(background.size()),
                  Eigen::VectorXf::Zero(background.size()),
                  Eigen::MatrixX3f::Zero(background.size(), 3)};
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Frame frame = on_device.render(views[v].sensor(), views[v].shot, {.graded = false});
    const std::vector<std::uint32_t> actor_of = actors[v].of(views[v].sensor().ray_count());
    // A particle's feature with uniform appearance is a constant plus kSh0 times its coefficient: the gradient
    // of the sum of the rays' features gives the sum of its weights. The first feature sums some rays, the
    // second the others.
    RayGradients of_rays;
    of_rays.feature[0].assign(actor_of.size(), 1.0F);
    of_rays.feature[1].assign(actor_of.size(), 0.0F);
    for (std::size_t ray = 0; ray < actor_of.size(); ++ray) {
      if (actor_of[ray] != 0) std::swap(of_rays.feature[0][ray], of_rays.feature[1][ray]);
    }
    const Eigen::MatrixXf gradients = on_device.gradients(frame, of_rays);
    const Eigen::VectorXf seen = gradients.col(kShRow) / kSh0;
    out.elsewhere += seen;
    out.before_actors += gradients.col(kShRow + 1) / kSh0;
    add_observations(background, views[v].shot.pose_at(0.5).translation - origin, seen, out.look);
  }
  return out;
}

}  // namespace simuli
