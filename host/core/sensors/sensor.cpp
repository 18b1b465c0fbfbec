#include "host/core/sensors/sensor.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/splitmix.hpp"

namespace simuli {
namespace {

/// A hash of numbers with one splitmix64 step each.
class Hash {
 public:
  void add(std::uint64_t word) { state_ = splitmix(state_ ^ word); }
  // 0 and -0 are equal and have equal hashes.
  void add(double value) { add(std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value)); }
  template <class Values>
  void add_all(const Values& values) {
    add(static_cast<std::uint64_t>(values.size()));
    for (const auto value : values) add(static_cast<double>(value));
  }
  [[nodiscard]] std::size_t value() const { return static_cast<std::size_t>(state_); }

 private:
  std::uint64_t state_ = 0;
};

void add(Hash& hash, const Camera& c) {
  for (const double value : {c.fx, c.fy, c.cx, c.cy}) hash.add(value);
  for (const int value : {c.width, c.height, static_cast<int>(c.shutter), static_cast<int>(c.lens.kind())}) {
    hash.add(static_cast<double>(value));
  }
  hash.add_all(c.lens.parameters());
  if (const std::optional<Windshield>& glass = c.lens.windshield()) {
    hash.add(static_cast<double>(glass->reference));
    for (const auto* const all :
         {&glass->horizontal, &glass->vertical, &glass->horizontal_inverse, &glass->vertical_inverse})
      hash.add_all(*all);
  }
}

void add(Hash& hash, const Lidar& l) {
  for (const double value : {l.azimuth_first, l.azimuth_span, l.spin_sign(), l.sweep_s, double(l.columns)}) {
    hash.add(value);
  }
  for (const LidarRow& r : l.rows) {
    for (const double value : {r.elevation, r.azimuth_offset, r.vertical_offset, r.time_offset}) {
      hash.add(value);
    }
    if (r.every > 1) hash.add(double(r.every * l.columns + r.first));
  }
  for (const BlindArc& arc : l.blind) hash.add(arc.azimuth_first);
}

void add(Hash& hash, const RayList& l) {
  hash.add_all(l.azimuth);
  hash.add_all(l.elevation);
  hash.add_all(l.time_fraction);
}

/// Validates a sensor's name, because files and messages contain it.
std::shared_ptr<const std::string> kept(std::string name) {
  need_name(name, "sensor", "name");
  return std::make_shared<const std::string>(std::move(name));
}

}  // namespace

/// The numbers of a sensor, and derived data.
struct Sensor::Model {
  explicit Model(Camera camera) : of(std::move(camera)), hash(hash_of()) {}
  Model(LidarModel lidar, std::optional<LidarRays> rays)
      : of(std::move(lidar)), measured(std::move(rays)), hash(hash_of()) {}

  [[nodiscard]] std::size_t hash_of() const {
    Hash sum;
    if (const auto* const camera = std::get_if<Camera>(&of)) {
      add(sum, *camera);
    } else {
      std::visit([&](const auto& model) { add(sum, model); }, std::get<LidarModel>(of));
    }
    if (measured) {
      sum.add_all(measured->azimuth);
      sum.add_all(measured->elevation);
      sum.add_all(measured->time_fraction);
    }
    return sum.value();
  }

  std::variant<Camera, LidarModel> of;
  std::optional<LidarRays> measured;
  std::size_t hash;
  // Made on demand.
  mutable std::once_flag fired_once;
  mutable LidarRays fired;
};

Sensor::Sensor(std::shared_ptr<const Model> model,
               std::shared_ptr<const std::string> name,
               const Pose& rig_from_sensor,
               double duration_s)
    : model_(std::move(model)),
      name_(std::move(name)),
      rig_from_sensor_(rig_from_sensor),
      duration_s_(duration_s) {}

Sensor::Sensor(Camera camera, const Pose& rig_from_sensor, double duration_s)
    : name_(kept(camera.name)), rig_from_sensor_(rig_from_sensor), duration_s_(duration_s) {
  const std::string where = "camera " + camera.name;
  validate(camera, where);
  if (!(duration_s >= 0.0 && std::isfinite(duration_s))) {
    throw_input_error(where, "duration", fmt::format("{} s", duration_s), "0 or more, finite");
  }
  model_ = std::make_shared<const Model>(std::move(camera));
}

Sensor::Sensor(LidarModel lidar, const Pose& rig_from_sensor)
    : name_(kept(name_of(lidar))), rig_from_sensor_(rig_from_sensor), duration_s_(sweep_s(lidar)) {
  validate(lidar, "LiDAR " + name_of(lidar));
  model_ = std::make_shared<const Model>(std::move(lidar), std::nullopt);
}

bool Sensor::is_camera() const { return std::holds_alternative<Camera>(model_->of); }

const Camera& Sensor::camera() const {
  if (const auto* const camera = std::get_if<Camera>(&model_->of)) return *camera;
  throw Error(ErrorKind::kUsage, fmt::format("sensor {}: found a LiDAR, allowed a camera", name()));
}

const LidarModel& Sensor::lidar() const {
  if (const auto* const lidar = std::get_if<LidarModel>(&model_->of)) return *lidar;
  throw Error(ErrorKind::kUsage, fmt::format("sensor {}: found a camera, allowed a LiDAR", name()));
}

std::size_t Sensor::rows() const {
  return is_camera() ? static_cast<std::size_t>(camera().height) : row_count(lidar());
}

std::size_t Sensor::columns() const {
  return is_camera() ? static_cast<std::size_t>(camera().width)
                     : simuli::ray_count(lidar()) / row_count(lidar());
}

const LidarRays& Sensor::rays() const {
  const LidarModel& model = lidar();
  if (model_->measured) return *model_->measured;
  std::call_once(model_->fired_once, [&] { model_->fired = nominal_rays(model); });
  return model_->fired;
}

Sensor Sensor::named(std::string name) const {
  return {model_, kept(std::move(name)), rig_from_sensor_, duration_s_};
}

Sensor Sensor::mounted(const Pose& rig_from_sensor) const {
  return {model_, name_, rig_from_sensor, duration_s_};
}

Sensor Sensor::with_duration(double duration_s) const {
  if (is_camera()) return Sensor(camera(), rig_from_sensor_, duration_s).named(name());
  if (duration_s == duration_s_) return *this;
  LidarModel model = lidar();
  std::visit([&](auto& m) { m.sweep_s = duration_s; }, model);
  const Sensor changed = Sensor(std::move(model), rig_from_sensor_).named(name());
  return model_->measured ? changed.with_rays(*model_->measured) : changed;
}

Sensor Sensor::with_rays(LidarRays rays) const {
  const LidarModel& model = lidar();
  const std::size_t count = simuli::ray_count(model);
  if (rays.azimuth.size() != count || rays.elevation.size() != count || rays.time_fraction.size() != count) {
    throw_input_error(
        "LiDAR " + name(),
        "measured rays",
        fmt::format(
            "{}, {} and {} values", rays.azimuth.size(), rays.elevation.size(), rays.time_fraction.size()),
        fmt::format("{} of each", count));
  }
  return {std::make_shared<const Model>(model, std::move(rays)), name_, rig_from_sensor_, duration_s_};
}

Sensor Sensor::resized(int width, int height) const {
  return Sensor(camera().resized(width, height), rig_from_sensor_, duration_s_).named(name());
}

bool Sensor::has_rays_of(const Sensor& other) const {
  if (model_ == other.model_) return true;
  return model_->hash == other.model_->hash && model_->of == other.model_->of &&
         model_->measured == other.model_->measured;
}

std::size_t Sensor::rays_hash() const { return model_->hash; }

}  // namespace simuli
