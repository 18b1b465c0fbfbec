// Trained stretches as files of blocks: what a training that goes on finds done.
#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <type_traits>

#include "host/core/base/error.hpp"
#include "io/base/state_file.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/state/state.hpp"
#include "optim/stretch/stretch_parts.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kIterationsKey = "iterations=";
constexpr const char* kStretchKey = "stretch=";

template <class T>
std::span<const std::byte> bytes_of(const T* values, std::size_t count) {
  return std::as_bytes(std::span<const T>(values, count));
}

template <class T>
std::vector<T> values_in(const StateFile& file, const std::string& name) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::vector<std::byte> bytes = file.block(name);
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// Error{kInput} unless there are so many.
template <class T>
std::vector<T> values_in(const StateFile& file, const std::string& name, std::size_t count) {
  std::vector<T> values = values_in<T>(file, name);
  if (values.size() == count) return values;
  throw_input_error(
      file.path().string(), name, fmt::format("{} values", values.size()), fmt::format("{}", count));
}

std::vector<std::string> lines_in(const StateFile& file, const std::string& name) {
  const std::vector<char> text = values_in<char>(file, name);
  std::vector<std::string> out;
  for (auto begin = text.begin(); begin != text.end();) {
    const auto end = std::find(begin, text.end(), '\n');
    out.emplace_back(begin, end);
    begin = end == text.end() ? end : end + 1;
  }
  return out;
}

void write_set(StateWriter& out, const std::string& name, const GaussianSet& set) {
  const auto degree = static_cast<std::uint32_t>(set.sh_degree);
  out.add(name + "/sh_degree", bytes_of(&degree, 1));
  out.add(name + "/actors", bytes_of(set.actor.data(), set.actor.size()));
  out.add(name + "/params", bytes_of(set.params.data(), static_cast<std::size_t>(set.params.size())));
}

GaussianSet read_set(const StateFile& file, const std::string& name, SetKind kind) {
  const auto degree = static_cast<int>(values_in<std::uint32_t>(file, name + "/sh_degree", 1).front());
  const std::vector<float> params = values_in<float>(file, name + "/params");
  const auto rows = static_cast<std::size_t>(param_rows(degree));
  GaussianSet set(kind, degree, static_cast<Eigen::Index>(params.size() / rows));
  if (static_cast<std::size_t>(set.params.size()) != params.size()) {
    throw_input_error(file.path().string(),
                      name + "/params",
                      fmt::format("{} values", params.size()),
                      fmt::format("a multiple of {}", rows));
  }
  if (!params.empty()) std::memcpy(set.params.data(), params.data(), params.size() * sizeof(float));
  set.actor = values_in<std::uint32_t>(file, name + "/actors");
  return set;
}

/// The numbers of a report that sums and judgements need.
std::vector<double> numbers_of(const TrainReport& r) {
  return {static_cast<double>(r.last.iteration),
          static_cast<double>(r.last.planned),
          r.last.psnr_db,
          r.last.distance_m,
          r.last.drop_accuracy,
          static_cast<double>(r.last.camera_particles),
          static_cast<double>(r.last.lidar_particles),
          static_cast<double>(r.images),
          static_cast<double>(r.sweeps),
          static_cast<double>(r.relocated),
          static_cast<double>(r.grown),
          static_cast<double>(r.pruned),
          r.row_ranges_m,
          r.anchor_m,
          r.seconds};
}

TrainReport report_of(const std::vector<double>& n) {
  TrainReport r;
  r.last = {static_cast<int>(n[0]),
            static_cast<int>(n[1]),
            n[2],
            n[3],
            n[4],
            static_cast<std::uint32_t>(n[5]),
            static_cast<std::uint32_t>(n[6])};
  r.images = static_cast<std::size_t>(n[7]);
  r.sweeps = static_cast<std::size_t>(n[8]);
  r.relocated = static_cast<std::uint64_t>(n[9]);
  r.grown = static_cast<std::uint64_t>(n[10]);
  r.pruned = static_cast<std::uint64_t>(n[11]);
  r.row_ranges_m = n[12];
  r.anchor_m = n[13];
  r.seconds = n[14];
  return r;
}

std::string block_of(const Actor& actor) { return "actor/" + actor.name; }

/// Nodes, begin and interval of its knots, offsets; none of a rigid actor.
std::vector<double> shape_numbers(const Deformation& shape) {
  if (shape.empty()) return {};
  std::vector<double> out(shape.nodes.begin(), shape.nodes.end());
  out.push_back(shape.start_s);
  out.push_back(shape.interval_s);
  out.insert(out.end(), shape.offsets_m.begin(), shape.offsets_m.end());
  return out;
}

Deformation shape_of(const std::vector<double>& numbers) {
  constexpr std::size_t kHeader = 5;
  Deformation shape;
  if (numbers.size() <= kHeader) return shape;
  for (std::size_t k = 0; k < 3; ++k) shape.nodes[k] = static_cast<int>(numbers[k]);
  shape.start_s = numbers[3];
  shape.interval_s = numbers[4];
  shape.offsets_m.assign(numbers.begin() + kHeader, numbers.end());
  return shape;
}

}  // namespace

std::string stretch_lines(int iterations, std::size_t index, std::size_t count) {
  return fmt::format("{}{}\n{}{} of {}\n", kIterationsKey, iterations, kStretchKey, index, count);
}

std::string stretch_lines(const std::filesystem::path& checkpoint) {
  const std::vector<char> bytes = values_in<char>(StateFile(checkpoint), kSettings);
  const std::string text(bytes.begin(), bytes.end());
  if (text.rfind(std::string("\n") + kStretchKey) == std::string::npos) return "";
  return text.substr(text.rfind(std::string("\n") + kIterationsKey) + 1);
}

std::filesystem::path stretch_file(const std::filesystem::path& checkpoint, std::size_t index) {
  return checkpoint.string() + fmt::format(".{}", index);
}

void write_stretch(const std::filesystem::path& file, const std::string& settings, const StretchScene& part) {
  const Scene& scene = part.scene;
  write_state_file(file, [&](StateWriter& out) {
    out.add(kSettings, bytes_of(settings.data(), settings.size()));
    const std::vector<double> report = numbers_of(part.report);
    out.add("report", bytes_of(report.data(), report.size()));
    write_set(out, "camera", scene.camera);
    write_set(out, "lidar", scene.lidar);
    out.add("background", bytes_of(scene.camera_background.data(), scene.camera_background.size()));
    const std::array<std::int32_t, 2> size = {scene.environment.width, scene.environment.height};
    out.add("environment/size", bytes_of(size.data(), size.size()));
    out.add("environment", bytes_of(scene.environment.texels.data(), scene.environment.texels.size()));
    std::string names;
    for (const Actor& actor : scene.actors) {
      names += actor.name + '\n';
      std::vector<double> offsets;
      for (const KeyPose& key : actor.track) {
        offsets.insert(offsets.end(), key.shift_m.begin(), key.shift_m.end());
        offsets.insert(offsets.end(), key.turn_rad.begin(), key.turn_rad.end());
      }
      out.add(block_of(actor), bytes_of(offsets.data(), offsets.size()));
      const std::vector<double> shape = shape_numbers(actor.deformation);
      out.add(block_of(actor) + "/shape", bytes_of(shape.data(), shape.size()));
    }
    out.add("actors", bytes_of(names.data(), names.size()));
    std::string hiding;
    for (const Actor& occluder : scene.occluders) hiding += occluder.name + '\n';
    out.add("occluders", bytes_of(hiding.data(), hiding.size()));
    for (const RayDrop& drop : scene.ray_drop) {
      out.add("ray_drop/" + drop.lidar, bytes_of(drop.parameters.data(), drop.parameters.size()));
    }
    for (const LogLidar& lidar : part.lidars) {
      std::vector<double> biases;
      if (const auto* const rows = std::get_if<Lidar>(&lidar.model)) {
        for (const LidarRow& row : rows->rows) biases.push_back(row.range_bias);
      }
      out.add("range_biases/" + name_of(lidar.model), bytes_of(biases.data(), biases.size()));
    }
  });
}

StretchScene read_stretch(const std::filesystem::path& path, const std::string& settings, const Log& log) {
  const StateFile file(path);
  StateList::need_text(path.string(), kSettings, file.block(kSettings), settings);
  StretchScene part;
  part.report = report_of(values_in<double>(file, "report", numbers_of({}).size()));
  Scene& scene = part.scene;
  scene.name = log.name;
  scene.origin = scene_origin(log.world_from_rig);
  scene.camera = read_set(file, "camera", SetKind::kCamera);
  scene.lidar = read_set(file, "lidar", SetKind::kLidar);
  const std::vector<float> background = values_in<float>(file, "background", 3);
  std::copy(background.begin(), background.end(), scene.camera_background.begin());
  const std::vector<std::int32_t> size = values_in<std::int32_t>(file, "environment/size", 2);
  scene.environment.width = size[0];
  scene.environment.height = size[1];
  scene.environment.texels = values_in<float>(file, "environment");
  for (const std::string& name : lines_in(file, "actors")) {
    Actor actor = log.actors[find_actor(log.actors, name)];
    const std::vector<double> offsets = values_in<double>(file, block_of(actor), 6 * actor.track.size());
    for (std::size_t k = 0; k < actor.track.size(); ++k) {
      actor.track[k].shift_m = Eigen::Vector3d(&offsets[6 * k]);
      actor.track[k].turn_rad = Eigen::Vector3d(&offsets[6 * k + 3]);
    }
    actor.deformation = shape_of(values_in<double>(file, block_of(actor) + "/shape"));
    validate(actor, path.string());
    scene.actors.push_back(std::move(actor));
  }
  for (const std::string& name : lines_in(file, "occluders")) {
    scene.occluders.push_back(scene.actors[find_actor(scene.actors, name)]);
    scene.occluders.back().deformation = {};
  }
  part.lidars = log.lidars;
  for (LogLidar& lidar : part.lidars) {
    const std::string& name = name_of(lidar.model);
    if (file.has("ray_drop/" + name)) {
      const std::vector<double> values = values_in<double>(file, "ray_drop/" + name, RayDrop::kParameters);
      RayDrop drop{name, {}};
      std::copy(values.begin(), values.end(), drop.parameters.begin());
      scene.ray_drop.push_back(drop);
    }
    auto* const rows = std::get_if<Lidar>(&lidar.model);
    if (rows == nullptr) continue;
    const std::vector<double> biases = values_in<double>(file, "range_biases/" + name, rows->rows.size());
    for (std::size_t row = 0; row < biases.size(); ++row) rows->rows[row].range_bias = biases[row];
  }
  std::sort(scene.ray_drop.begin(), scene.ray_drop.end(), [](const RayDrop& a, const RayDrop& b) {
    return a.lidar < b.lidar;
  });
  return part;
}

const StretchScene& StretchParts::part(std::size_t index, const Log& log) {
  const StoredPart& kept = kept_.at(index);
  if (kept.file.empty()) return kept.part;
  read_ = {};
  read_ = read_stretch(kept.file, kept.settings, log);
  return read_;
}

}  // namespace simuli
