#include "io/import/ros2/cloud_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>

#include "host/core/base/error.hpp"
#include "host/core/base/split.hpp"

namespace simuli::ros2 {
namespace {

constexpr double kNanosecond_s = 1e-9;
constexpr double kMostFromStamp_s = 10.0;
constexpr double kFarthest_m = 1e5;

struct KnownTime {
  const char* name;
  std::uint8_t datatype;
  double unit_s;
  bool is_absolute;
};
constexpr KnownTime kTimes[] = {{"time", PointField::kFloat32, 1.0, false},
                                {"t", PointField::kUint32, kNanosecond_s, false},
                                {"time_stamp", PointField::kUint32, kNanosecond_s, false},
                                {"offset_time", PointField::kUint32, kNanosecond_s, false},
                                {"timestamp", PointField::kFloat64, 0.0, true}};

struct Unit {
  const char* name;
  double s;
};
constexpr Unit kUnits[] = {{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", kNanosecond_s}};

template <class T>
double as_double(const char* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double value_of(const CloudField& field, const char* point) {
  const char* at = point + field.offset;
  switch (field.datatype) {
    case PointField::kInt8:
      return as_double<std::int8_t>(at);
    case PointField::kUint8:
      return as_double<std::uint8_t>(at);
    case PointField::kInt16:
      return as_double<std::int16_t>(at);
    case PointField::kUint16:
      return as_double<std::uint16_t>(at);
    case PointField::kInt32:
      return as_double<std::int32_t>(at);
    case PointField::kUint32:
      return as_double<std::uint32_t>(at);
    case PointField::kFloat32:
      return as_double<float>(at);
    default:
      return as_double<double>(at);
  }
}

/// Finds the fields of a cloud and their errors.
class Finder {
 public:
  Finder(const PointCloudMessage& message, const std::string& file, const std::string& where)
      : message_(message), file_(file), where_(where) {}

  [[nodiscard]] std::optional<CloudField> find(const std::string& name) const {
    for (const PointField& field : message_.fields) {
      if (field.name == name) return CloudField{name, field.offset, field.datatype};
    }
    return {};
  }
  [[nodiscard]] CloudField need(const std::string& name, const char* why) const {
    const auto found = find(name);
    if (!found) refuse("fields", names(), fmt::format("one called {}: {}", name, why));
    return *found;
  }
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(file_, where_ + ": " + field, found, allowed);
  }
  [[nodiscard]] std::string names() const {
    std::string all;
    for (const PointField& field : message_.fields) all += (all.empty() ? "" : ", ") + field.name;
    return all.empty() ? "none" : all;
  }

 private:
  const PointCloudMessage& message_;
  const std::string& file_;
  const std::string& where_;
};

void find_time(const Finder& finder, const std::string& requested, CloudFields& fields) {
  if (!requested.empty()) {
    const std::vector<std::string> parts = split(requested, ':');
    const auto* unit = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) {
      return parts.size() > 1 && parts[1] == u.name;
    });
    const bool is_absolute = parts.size() == 3 && parts[2] == "absolute";
    if (unit == std::end(kUnits) || parts.size() > 3 || (parts.size() == 3 && !is_absolute)) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("--point-time: found \"{}\", allowed FIELD:UNIT or FIELD:UNIT:absolute, UNIT s, ms, "
                      "us or ns",
                      requested));
    }
    fields.time = finder.need(parts[0], "--point-time");
    fields.time_unit_s = unit->s;
    fields.time_is_absolute = is_absolute;
    return;
  }
  for (const KnownTime& known : kTimes) {
    const auto field = finder.find(known.name);
    if (!field) continue;
    if (field->datatype != known.datatype) {
      finder.refuse(std::string("field ") + known.name,
                    fmt::format("of type {}", field->datatype),
                    fmt::format("type {}, or --point-time {}:UNIT", known.datatype, known.name));
    }
    fields.time = field;
    fields.time_unit_s = known.unit_s;
    fields.time_is_absolute = known.is_absolute;
    return;
  }
}

void find_intensity(const Finder& finder, const std::string& requested, CloudFields& fields) {
  if (requested.empty()) {
    const bool is_ouster = finder.find("t") && finder.find("reflectivity");
    fields.intensity = finder.find(is_ouster ? "reflectivity" : "intensity");
    return;
  }
  const std::vector<std::string> parts = split(requested, ':');
  char* end = nullptr;
  const double most = parts.size() == 2 ? std::strtod(parts[1].c_str(), &end) : 0.0;
  if (parts.size() != 2 || *end != '\0' || !(most > 0.0) || !std::isfinite(most)) {
    throw Error(ErrorKind::kUsage,
                fmt::format("--intensity: found \"{}\", allowed FIELD:MOST, MOST above 0", requested));
  }
  fields.intensity = finder.need(parts[0], "--intensity");
  fields.intensity_most = most;
}

/// Returns the time after the stamp.
double time_of(double value, const CloudFields& fields, double stamp_s) {
  if (!fields.time_is_absolute) return value * fields.time_unit_s;
  if (fields.time_unit_s > 0.0) return value * fields.time_unit_s - stamp_s;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Unit& unit : kUnits) {
    const double after_s = value * unit.s - stamp_s;
    if (std::abs(after_s) < std::abs(nearest)) nearest = after_s;
  }
  return nearest;
}

}  // namespace

std::string CloudFields::reported() const {
  std::string text = ring ? ring->name : "no ring (rows by elevation)";
  text += time ? ", " + time->name : ", no times (by the columns)";
  text += intensity ? fmt::format(", {} to {:g}", intensity->name, intensity_most) : ", no intensity (0)";
  return text;
}

CloudFields find_cloud_places(const PointCloudMessage& message,
                              const std::string& file,
                              const std::string& where) {
  const Finder finder(message, file, where);
  CloudFields fields;
  constexpr std::array<const char*, 3> kXyz{"x", "y", "z"};
  for (std::size_t i = 0; i < kXyz.size(); ++i) {
    fields.xyz[i] = finder.need(kXyz[i], "coordinates in m");
    const std::uint8_t type = fields.xyz[i].datatype;
    if (type != PointField::kFloat32 && type != PointField::kFloat64)
      finder.refuse(
          std::string("field ") + kXyz[i], fmt::format("of type {}", type), "7 or 8: float32 or float64");
  }
  return fields;
}

CloudFields find_cloud_fields(const PointCloudMessage& message,
                              const CloudFieldOptions& options,
                              const std::string& file,
                              const std::string& where) {
  const Finder finder(message, file, where);
  CloudFields fields = find_cloud_places(message, file, where);
  for (const char* name : {"ring", "channel"}) {
    if (fields.ring) break;
    fields.ring = finder.find(name);
    if (!fields.ring) continue;
    const std::uint8_t type = fields.ring->datatype;
    if (type != PointField::kUint8 && type != PointField::kUint16 && type != PointField::kUint32)
      finder.refuse(
          std::string("field ") + name, fmt::format("of type {}", type), "2, 4 or 6: an unsigned one");
  }
  find_time(finder, options.time, fields);
  find_intensity(finder, options.intensity, fields);
  return fields;
}

std::vector<CloudPoint> points_of(const PointCloudMessage& message,
                                  const CloudFields& fields,
                                  const std::string& file,
                                  const std::string& where) {
  const auto refuse = [&](const std::string& field, double found, const std::string& allowed) {
    throw_input_error(file, where + ": " + field, fmt::format("{}", found), allowed);
  };
  const double stamp_s = static_cast<double>(message.header.stamp_ns) * kNanosecond_s;
  std::vector<CloudPoint> points;
  for (std::size_t row = 0; row < message.height; ++row) {
    for (std::size_t i = 0; i < message.width; ++i) {
      const char* at = message.data.data() + row * message.row_step + i * message.point_step;
      CloudPoint point;
      for (std::size_t k = 0; k < 3; ++k)
        point.position[static_cast<Eigen::Index>(k)] = value_of(fields.xyz[k], at);
      if (!point.position.allFinite() || point.position.isZero(0.0)) continue;
      if (!(point.position.cwiseAbs().maxCoeff() <= kFarthest_m))
        refuse("x, y, z", point.position.cwiseAbs().maxCoeff(), fmt::format("at most {} m", kFarthest_m));
      if (fields.ring) point.ring = static_cast<int>(std::min(value_of(*fields.ring, at), 65535.0));
      if (fields.time) {
        point.time_s = time_of(value_of(*fields.time, at), fields, stamp_s);
        if (!(std::abs(point.time_s) <= kMostFromStamp_s)) {
          refuse("field " + fields.time->name,
                 point.time_s,
                 fmt::format("within {} s of the stamp, or --point-time for another unit", kMostFromStamp_s));
        }
      }
      if (fields.intensity) {
        const double value = value_of(*fields.intensity, at);
        if (!(value >= 0.0 && value <= fields.intensity_most)) {
          refuse(
              "field " + fields.intensity->name,
              value,
              fmt::format("0 to {:g}, or --intensity FIELD:MOST for another range", fields.intensity_most));
        }
        point.intensity = static_cast<float>(value / fields.intensity_most);
      }
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace simuli::ros2
