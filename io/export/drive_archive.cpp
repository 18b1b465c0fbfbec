#include "io/export/drive_archive.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "host/core/base/version.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "io/archive/stored_zip.hpp"
#include "io/base/bytes.hpp"
#include "io/base/file.hpp"
#include "io/export/drive_parts.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo), 64 bits, continued from `hash`.
std::uint64_t hash_of(const std::string& text, std::uint64_t hash) {
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3U;
  return hash;
}

/// Returns the same id for equal tracks with the same name: version 8 of RFC 9562 (application-defined).
std::string uuid_of(const std::string& text) {
  const std::uint64_t a = hash_of(text, 0xcbf29ce484222325U), b = hash_of(text, a);
  return fmt::format("{:08x}-{:04x}-8{:03x}-{:04x}-{:012x}",
                     a >> 32U,
                     a >> 16U & 0xffffU,
                     a & 0xfffU,
                     (b >> 48U & 0x3fffU) | 0x8000U,
                     b & 0xffffffffffffU);
}

/// Returns YAML with JSON values, one per line.
std::string metadata_of(const SceneFile& file,
                        const SceneClock& clock,
                        const std::string& scene_id,
                        const std::string& uuid) {
  Json cameras = Json::array(), lidars = Json::array();
  for (const LogCamera& camera : file.cameras) cameras.push_back(camera.model.name);
  for (const LogLidar& lidar : file.lidars) lidars.push_back(name_of(lidar.model));
  const Json values{{"scene_id", scene_id},
                    {"version_string", std::string("simuli ") + version()},
                    {"training_date", "unknown"},
                    {"dataset_hash", file.training ? file.training->log_hash : ""},
                    {"uuid", uuid},
                    {"is_resumable", false},
                    {"sensors", {{"camera_ids", cameras}, {"lidar_ids", lidars}}},
                    {"logger", {{"name", nullptr}, {"run_id", nullptr}, {"run_url", nullptr}}},
                    {"time_range",
                     {{"start", static_cast<double>(clock.microseconds(file.world_from_rig.start_s()))},
                      {"end", static_cast<double>(clock.microseconds(file.world_from_rig.end_s()))}}},
                    {"training_step_outputs", Json::object()}};
  std::string out;
  for (const auto& [key, value] : values.items()) out += key + ": " + text_of(value) + '\n';
  return out;
}

}  // namespace

DriveArchive write_drive_archive(const std::filesystem::path& file,
                                 const SceneFile& scene,
                                 const std::string& scene_id) {
  const std::string name = file.string();
  if (file.extension() != ".usdz") {
    throw_input_error(name, "extension", '"' + file.extension().string() + '"', ".usdz");
  }
  if (scene.world_from_rig.poses().empty()) throw_input_error(name, "path", "none", "that of a drive");
  if (scene.cameras.empty()) throw_input_error(name, "cameras", "none", "at least one");
  const SceneClock clock(scene.world_from_rig);
  const Json rig = rig_trajectories(scene, clock, scene_id), tracks = sequence_tracks(scene.scene, clock);
  const std::string rig_text = text_of(rig), tracks_text = text_of(tracks);
  DriveArchive out;
  out.actors = tracks.at("dummy_chunk_id").at("tracks_data").at("tracks_id").size();
  for (const Json& camera : rig.at("camera_calibrations")) {
    if (camera.at("camera_model").at("type") == kUnknownLens) ++out.cameras_without_model;
  }
  StoredZip zip(name, kUsdzAlignment);
  zip.add(kUsdzLayer, usda_of(background_of(scene.scene, SetKind::kCamera), SplatAxes::kZUp, name));
  zip.add("metadata.yaml", metadata_of(scene, clock, scene_id, uuid_of(scene_id + rig_text + tracks_text)));
  zip.add("rig_trajectories.json", rig_text);
  zip.add("sequence_tracks.json", tracks_text);
  zip.add("data_info.json",
          text_of({{"sequence_id", scene_id},
                   {"pose-range",
                    {{"start-timestamp_us", clock.microseconds(scene.world_from_rig.start_s())},
                     {"end-timestamp_us", clock.microseconds(scene.world_from_rig.end_s())}}}}));
  const GroundMap ground = ground_of(scene.scene);
  zip.add("map.xodr", road_map(local_path(scene), ground));
  const TriangleMesh mesh = ground_mesh(ground, scene.scene, scene.world_from_rig);
  out.ground_triangles = mesh.triangles.size();
  if (!mesh.triangles.empty()) {
    const std::string ply = ply_of(mesh);
    // The mesh contains the ground only; readers use either name.
    for (const char* entry : {"mesh_ground.ply", "mesh.ply"}) zip.add(entry, ply);
  }
  write_file_atomically(file, zip.finish());
  return out;
}

std::string ply_of(const TriangleMesh& mesh) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(),
      mesh.triangles.size());
  for (const Eigen::Vector3f& v : mesh.vertices) {
    for (int c = 0; c < 3; ++c) append_little_endian(out, std::bit_cast<std::uint32_t>(v[c]), 4);
  }
  for (const auto& triangle : mesh.triangles) {
    append_little_endian(out, triangle.size(), 1);
    for (const std::uint32_t vertex : triangle) append_little_endian(out, vertex, 4);
  }
  return out;
}

}  // namespace simuli
