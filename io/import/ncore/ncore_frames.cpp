#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/import/ncore/ncore_sequence.hpp"
#include "io/ncore/names.hpp"

namespace simuli::ncore {
namespace {

constexpr std::uint64_t kLastStamp_us = 4'000'000'000'000'000;  // 2096

template <class T>
std::vector<T> numbers(const ZarrGroup& place, const char* type, const std::vector<std::size_t>& shape) {
  const ZarrArray array = read_zarr_array(*place.store, place.path);
  if (array.type != type || array.shape != shape) {
    throw_input_error(place.file(),
                      "dtype and shape",
                      fmt::format("{} of {}", array.type.substr(0, 20), fmt::join(array.shape, " x ")),
                      fmt::format("{} of {}", type, fmt::join(shape, " x ")));
  }
  std::vector<T> out(array.bytes.size() / sizeof(T));
  std::memcpy(out.data(), array.bytes.data(), out.size() * sizeof(T));
  return out;
}

std::size_t count_of(const ZarrGroup& group, const char* key) {
  const Json attributes = group.attributes();
  const auto found = attributes.find(key);
  constexpr std::uint64_t kMost = std::uint64_t{1} << 24U;
  if (found != attributes.end() && found->is_number_unsigned() && found->get<std::uint64_t>() <= kMost)
    return found->get<std::size_t>();
  throw_input_error(group.file(), key, "none, or no number", fmt::format("at most {}", kMost));
}

}  // namespace

RayBundle read_rays(const ZarrGroup& frame, std::size_t& echoes) {
  const ZarrGroup bundle = frame / "ray_bundle", all = frame / "ray_bundle_returns";
  const std::size_t n = count_of(bundle, "n_rays"), returns = count_of(all, "n_returns");
  RayBundle out;
  out.direction = numbers<float>(bundle / "direction", "<f4", {n, 3});
  out.timestamp_us = numbers<std::uint64_t>(bundle / "timestamp_us", "<u8", {n});
  const ZarrGroup element = bundle / "model_element";
  if (element.is_there()) out.element = numbers<std::uint16_t>(element, "<u2", {n, 2});
  const auto distance = numbers<float>(all / "distance_m", "<f4", {returns, n}),
             intensity = numbers<float>(all / "intensity", "<f4", {returns, n});
  const auto mask = numbers<std::uint8_t>(frame / kValidMask, "|u1", {(returns * n + 7) / 8});
  out.distance.assign(n, std::numeric_limits<float>::quiet_NaN());
  out.intensity = out.distance;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f d(out.direction[3 * i], out.direction[3 * i + 1], out.direction[3 * i + 2]);
    constexpr float kUnit = 1e-3F;
    if (!(std::abs(d.squaredNorm() - 1.0F) <= kUnit)) {
      throw_input_error(
          bundle.file(), fmt::format("direction[{}]", i), fmt::format("of length {}", d.norm()), "1");
    }
    if (out.timestamp_us[i] > kLastStamp_us)
      throw_input_error(
          bundle.file(), fmt::format("timestamp_us[{}]", i), "a time beyond 2096", "microseconds");
    for (std::size_t r = 0; r < returns; ++r) {
      const std::size_t at = r * n + i;
      const bool is_valid = (mask[at / 8] & 0x80U >> at % 8) != 0;
      if (!is_valid || std::isnan(distance[at])) continue;
      if (!(distance[at] >= 0.0F && distance[at] <= 1e5F && intensity[at] >= 0.0F && intensity[at] <= 1.0F)) {
        throw_input_error(all.file(),
                          fmt::format("distance_m, intensity [{}][{}]", r, i),
                          fmt::format("{} m, {}", distance[at], intensity[at]),
                          "0 to 100000 m, 0 to 1");
      }
      if (distance[at] == 0.0F) continue;
      if (out.distance[i] > 0.0F) {
        ++echoes;
        continue;
      }
      out.distance[i] = distance[at];
      out.intensity[i] = intensity[at];
    }
  }
  return out;
}

Exact read_exact(const ZarrGroup& frame) {
  const ZarrGroup data = frame / "generic_data", ray = data / kExactRay;
  if (!ray.is_there() || !(data / kExactValues).is_there()) return {};
  const ZarrArray rays = read_zarr_array(*ray.store, ray.path);
  if (rays.shape.size() != 1) throw_input_error(ray.file(), "shape", "another", "a list");
  const std::size_t n = rays.shape[0];
  return {numbers<std::uint32_t>(ray, "<u4", {n}), numbers<float>(data / kExactValues, "<f4", {n, 4})};
}

namespace {

/// One observation of a box.
struct Box {
  std::string id, kind, frame;
  std::uint64_t time_us = 0, frame_us = 0;
  Eigen::Vector3d centre, size, euler;
};

Box read_box(JsonObject& b) {
  b.ignore_other_keys();
  const auto stamp = [&](const char* key) {
    return static_cast<std::uint64_t>(b.integer(key, 0, static_cast<std::int64_t>(kLastStamp_us)));
  };
  Box out{b.text("track_id"),
          b.text("class_id"),
          b.text("reference_frame_id"),
          stamp("timestamp_us"),
          stamp("reference_frame_timestamp_us"),
          {},
          {},
          {}};
  b.object("bbox3", [&](JsonObject& box) {
    box.ignore_other_keys();
    out.centre = box.vector<3>("centroid");
    out.size = box.vector<3>("dim");
    out.euler = box.vector<3>("rot");
  });
  return out;
}

/// Returns the stored exact rotation if the Euler angles are its rounded form.
Eigen::Quaterniond exact_rotation(const Box& box, const Json& ours, std::size_t i) {
  const Eigen::Quaterniond rotation = rotation_of_euler(box.euler);
  const auto all = ours.find("rotations_wxyz");
  if (all == ours.end() || !all->is_array() || i >= all->size()) return rotation;
  const auto exact = rotation_from((*all)[i]);
  constexpr double kRounding_rad = 1e-7;  // for angles near gimbal lock
  return exact && exact->angularDistance(rotation) < kRounding_rad ? *exact : rotation;
}

}  // namespace

std::vector<Actor> actors_of(const Sequence& sequence,
                             const Sequence::Path& path,
                             const std::string& world,
                             const std::string& rig,
                             std::size_t& unposed,
                             LabelReport& report) {
  LabelTracks tracks;
  const PoseTable& poses = sequence.poses();
  for (const auto& [name, place] : sequence.instances("cuboids")) {
    const ZarrGroup group = place / "cuboids";
    if (!group.is_there()) continue;
    const Json attributes = group.attributes(), ours = ours_of(place.attributes());
    JsonObject root(group.file(), "", attributes);
    const std::vector<Box> boxes = root.objects("cuboid_track_observations", read_box);
    std::vector<std::uint64_t> stamps;
    for (const Box& box : boxes) stamps.push_back(box.time_us);
    const std::vector<double> times_s = sequence.times_of(stamps, ours);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Box& box = boxes[i];
      const Pose frame_from_box{exact_rotation(box, ours, i), box.centre};
      Pose world_from_frame;
      if (const auto fixed = poses.fixed(world, box.frame)) {
        world_from_frame = *fixed;
      } else {
        const auto mounted = poses.fixed(rig, box.frame);
        const double frame_s = sequence.clock().seconds(box.frame_us);
        if (!mounted || frame_s < path.first_s || frame_s > path.last_s) {
          ++unposed;
          continue;
        }
        world_from_frame = path.trajectory.at(frame_s) * *mounted;
      }
      KeyPose key;
      key.time_s = times_s[i];
      // A product would round poses in world coordinates.
      key.world_from_actor = box.frame == world ? frame_from_box : world_from_frame * frame_from_box;
      tracks.add(box.id, box.kind, key, box.size, box.id.empty() ? "track" : name_from(box.id));
    }
  }
  return tracks.take(sequence.file(), report);
}

}  // namespace simuli::ncore
