#include "io/export/frame_labels.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/export/track_labels.hpp"
#include "io/picture/image.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

void need_pinhole(const std::string& format, const Sensor& sensor) {
  if (!sensor.is_camera()) return;
  const Lens& lens = sensor.camera().lens;
  if (lens.kind() == LensKind::kPinhole && !lens.windshield()) return;
  throw Error(
      ErrorKind::kUsage,
      fmt::format(
          "--labels {}: found camera {} with the lens {}{}, allowed pinhole, or --labels coco or json",
          format,
          sensor.name(),
          to_string(lens.kind()),
          lens.windshield() ? " behind a windshield" : ""));
}

/// Links the file under a second name, or copies it if the file system does not support links.
void also_as(const fs::path& file, const fs::path& name) {
  std::error_code failed;
  fs::create_hard_link(file, name, failed);
  if (failed) fs::copy_file(file, name, failed);
  if (failed) throw_input_error(name.string(), "file", failed.message(), "a place that can be written");
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

// ---- KITTI ----

int occluded(const ActorLabel& label) {
  const double share = label.occlusion.value_or(0.0);
  return share < 0.1 ? 0 : share < 0.5 ? 1 : 2;
}

std::string kitti_class(const std::string& kind) {
  return has_label_class(kind, LabelNames::kKitti) ? label_class_of(kind, LabelNames::kKitti) : "Misc";
}

/// Returns the line from the type on.
std::string kitti_line(const ActorLabel& label, const std::string& kind, const Camera& camera) {
  const Pose& camera_from_actor = label.sensor_from_actor;
  const Eigen::Vector3d ahead = camera_from_actor.rotation * Eigen::Vector3d::UnitX();
  const double turn = std::atan2(-ahead.z(), ahead.x());
  Eigen::Vector3d base = camera_from_actor.translation;
  const double seen_from = turn - std::atan2(base.x(), base.z());
  base.y() += 0.5 * label.size_m.z();
  const PixelBox box = label.projected_px.value_or(label.visible_px.value_or(PixelBox{}));
  const auto at = [](double px, int side) { return std::clamp(px - 0.5, 0.0, side - 1.0); };
  return fmt::format(
      "{} {:.4f} {} {:.6f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.4f} {:.6f}\n",
      kitti_class(kind),
      label.truncation,
      occluded(label),
      wrapped(seen_from),
      at(box.left, camera.width),
      at(box.top, camera.height),
      at(box.right, camera.width),
      at(box.bottom, camera.height),
      label.size_m.z(),
      label.size_m.y(),
      label.size_m.x(),
      base.x(),
      base.y(),
      base.z(),
      turn);
}

std::string matrix_line(const char* key, const Eigen::Matrix<double, 3, Eigen::Dynamic>& matrix) {
  std::string line = fmt::format("{}:", key);
  for (Eigen::Index r = 0; r < 3; ++r) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) line += fmt::format(" {:.12e}", matrix(r, c));
  }
  return line + '\n';
}

Eigen::Matrix3d intrinsic(const Camera& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = camera.fx, k(1, 1) = camera.fy;
  k(0, 2) = camera.cx - 0.5,
       k(1, 2) = camera.cy - 0.5;  // KITTI counts pixels from the centre of the first one
  return k;
}

std::string kitti_calibration(const Sensor& sensor) {
  Eigen::Matrix<double, 3, 4> p = Eigen::Matrix<double, 3, 4>::Zero();
  p.leftCols<3>() = intrinsic(sensor.camera());
  std::string text;
  for (const char* key : {"P0", "P1", "P2", "P3"}) text += matrix_line(key, p);
  text += matrix_line("R0_rect", Eigen::Matrix3d::Identity());
  const Eigen::Matrix4d camera_from_rig = sensor.rig_from_sensor().inverse().matrix();
  text += matrix_line("Tr_velo_to_cam", camera_from_rig.topRows<3>());
  text += matrix_line("Tr_imu_to_velo", Eigen::Matrix<double, 3, 4>::Identity());
  return text;
}

// ---- COCO ----

/// Returns run lengths in pycocotools' text format: differences to the second last value, six bits per letter.
std::string run_text(const std::vector<std::uint32_t>& runs) {
  std::string out;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::int64_t x = runs[i];
    if (i > 2) x -= runs[i - 2];
    for (bool more = true; more;) {
      auto letter = static_cast<char>(x & 0x1F);
      x >>= 5;
      more = (letter & 0x10) != 0 ? x != -1 : x != 0;
      if (more) letter = static_cast<char>(letter | 0x20);
      out += static_cast<char>(letter + 48);
    }
  }
  return out;
}

Json coco_box(const std::optional<PixelBox>& box) {
  if (!box) return {};
  return {box->left, box->top, box->right - box->left, box->bottom - box->top};
}

// ---- nuScenes ----

std::string token(char table, std::size_t index) {
  return fmt::format("{:02x}{:030x}", static_cast<unsigned>(table), index);
}

Json translation_of(const Pose& pose) {
  return {pose.translation.x(), pose.translation.y(), pose.translation.z()};
}
Json rotation_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return {q.w(), q.x(), q.y(), q.z()};
}

/// Returns nuScenes' visibility level by the visible share of the body: up to 40, 60, 80, 100 %.
std::string visibility_of(double seen) {
  return seen < 0.4 ? "1" : seen < 0.6 ? "2" : seen < 0.8 ? "3" : "4";
}

/// Returns nuScenes' time stamp: the middle of a picture, the end of a sweep.
double stamp_s(const FramesRecord& record, const FrameRecord& frame) {
  return record.sensor.is_camera() ? 0.5 * (frame.time_start_s + frame.time_end_s) : frame.time_end_s;
}
std::int64_t stamp_us(double time_s) { return std::llround(time_s * 1e6 + kNuscenesStart_us); }

Pose rig_at_stamp(const FramesRecord& record, const FrameRecord& frame) {
  const Pose world_from_sensor =
      record.sensor.is_camera() ? interpolate(frame.world_from_sensor_start, frame.world_from_sensor_end, 0.5)
                                : frame.world_from_sensor_end;
  return world_from_sensor * record.sensor.rig_from_sensor().inverse();
}

/// Links the entries of a chain to each other.
void chain(Json& table, const std::vector<std::size_t>& entries) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    Json& entry = table[entries[i]];
    entry["prev"] = i > 0 ? table[entries[i - 1]]["token"] : Json("");
    entry["next"] = i + 1 < entries.size() ? table[entries[i + 1]]["token"] : Json("");
  }
}

/// Returns the frame nearest in time.
std::size_t nearest(const FramesRecord& record, double time_s) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < record.frames.size(); ++i) {
    const auto away = [&](std::size_t k) { return std::abs(stamp_s(record, record.frames[k]) - time_s); };
    if (away(i) < away(best)) best = i;
  }
  return best;
}

class NuscenesTables {
 public:
  explicit NuscenesTables(const std::vector<LabelledFrames>& all) : all_(all) {
    const auto lidar = std::find_if(
        all.begin(), all.end(), [](const LabelledFrames& f) { return !f.record.sensor.is_camera(); });
    first_ = lidar == all.end() ? 0 : static_cast<std::size_t>(lidar - all.begin());
    for (const char* name : {"attribute",
                             "calibrated_sensor",
                             "category",
                             "ego_pose",
                             "instance",
                             "log",
                             "map",
                             "sample",
                             "sample_annotation",
                             "sample_data",
                             "scene",
                             "sensor",
                             "visibility"}) {
      tables_[name] = Json::array();
    }
    add_scene();
    for (std::size_t s = 0; s < all.size(); ++s) add_sensor(s);
    add_annotations();
  }
  void write(const fs::path& folder) const {
    fs::create_directories(folder);
    for (const auto& [name, table] : tables_)
      write_file_atomically(folder / (name + ".json"),
                            table.dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
  }

 private:
  [[nodiscard]] const FramesRecord& main() const { return all_[first_].record; }

  void add_scene() {
    const FramesRecord& record = main();
    const std::size_t count = record.frames.size();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < count; ++i) {
      order.push_back(i);
      tables_["sample"].push_back({{"token", token('s', i)},
                                   {"timestamp", stamp_us(stamp_s(record, record.frames[i]))},
                                   {"scene_token", token('S', 0)}});
    }
    chain(tables_["sample"], order);
    tables_["scene"].push_back({{"token", token('S', 0)},
                                {"name", record.scene},
                                {"description", "rendered by simuli " + record.version},
                                {"log_token", token('l', 0)},
                                {"nbr_samples", count},
                                {"first_sample_token", token('s', 0)},
                                {"last_sample_token", token('s', count - 1)}});
    tables_["log"].push_back({{"token", token('l', 0)},
                              {"logfile", record.trajectory},
                              {"vehicle", "simuli"},
                              {"date_captured", "1970-01-12"},
                              {"location", "nowhere"}});
    tables_["map"].push_back({{"token", token('m', 0)},
                              {"log_tokens", {token('l', 0)}},
                              {"category", "semantic_prior"},
                              {"filename", "maps/none.png"}});
    const char* const levels[] = {"v0-40", "v40-60", "v60-80", "v80-100"};
    for (int i = 0; i < 4; ++i) {
      tables_["visibility"].push_back({{"token", std::to_string(i + 1)},
                                       {"level", levels[i]},
                                       {"description", "share of the body's pixels that nothing hides"}});
    }
  }

  void add_sensor(std::size_t s) {
    const auto& [folder, record] = all_[s];
    const Sensor& sensor = record.sensor;
    tables_["sensor"].push_back({{"token", token('c', s)},
                                 {"channel", sensor.name()},
                                 {"modality", sensor.is_camera() ? "camera" : "lidar"}});
    Json rows = Json::array();
    if (sensor.is_camera()) {
      const Eigen::Matrix3d k = intrinsic(sensor.camera());
      for (Eigen::Index r = 0; r < 3; ++r) rows.push_back({k(r, 0), k(r, 1), k(r, 2)});
    }
    tables_["calibrated_sensor"].push_back({{"token", token('k', s)},
                                            {"sensor_token", token('c', s)},
                                            {"translation", translation_of(sensor.rig_from_sensor())},
                                            {"rotation", rotation_of(sensor.rig_from_sensor())},
                                            {"camera_intrinsic", rows}});
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < record.frames.size(); ++i) {
      const FrameRecord& frame = record.frames[i];
      const std::size_t number = tables_["sample_data"].size();
      const double time_s = stamp_s(record, frame);
      const std::size_t sample = s == first_ ? i : nearest(main(), time_s);
      const bool is_key = s == first_ || nearest(record, stamp_s(main(), main().frames[sample])) == i;
      const Pose world_from_rig = rig_at_stamp(record, frame);
      tables_["ego_pose"].push_back({{"token", token('e', number)},
                                     {"timestamp", stamp_us(time_s)},
                                     {"translation", translation_of(world_from_rig)},
                                     {"rotation", rotation_of(world_from_rig)}});
      const fs::path file(frame.data);
      tables_["sample_data"].push_back(
          {{"token", token('d', number)},
           {"sample_token", token('s', sample)},
           {"ego_pose_token", token('e', number)},
           {"calibrated_sensor_token", token('k', s)},
           {"timestamp", stamp_us(time_s)},
           {"fileformat", sensor.is_camera() ? file.extension().string().substr(1) : std::string("pcd")},
           {"is_key_frame", is_key},
           {"width", sensor.is_camera() ? sensor.camera().width : 0},
           {"height", sensor.is_camera() ? sensor.camera().height : 0},
           {"filename", (fs::path(folder) / file).generic_string()}});
      order.push_back(number);
      if (!is_key) continue;
      for (const ActorLabel& label : frame.labels) {
        Seen& seen = seen_[{label.actor, sample}];
        if (seen.label == nullptr || s == first_) seen.label = &label;
        if (!sensor.is_camera()) seen.returns += label.rays;
        seen.rays += label.rays;
        if (sensor.is_camera() && label.rays > 0)
          seen.share = std::max(seen.share, 1.0 - label.occlusion.value_or(0.0));
      }
    }
    chain(tables_["sample_data"], order);
  }

  void add_annotations() {
    std::map<std::string, std::string> categories;
    std::map<std::size_t, std::vector<std::size_t>> of_actor;  // in sample order
    for (const auto& [who, seen] : seen_) {
      if (seen.rays == 0) continue;
      const auto [actor, sample] = who;
      const ActorLabel& label = *seen.label;
      std::vector<std::size_t>& order = of_actor[actor];
      order.push_back(tables_["sample_annotation"].size());
      tables_["sample_annotation"].push_back(
          {{"token", token('a', order.back())},
           {"sample_token", token('s', sample)},
           {"instance_token", token('i', actor)},
           {"visibility_token", visibility_of(seen.share)},
           {"attribute_tokens", Json::array()},
           {"translation", translation_of(label.world_from_actor)},
           {"size", {label.size_m.y(), label.size_m.x(), label.size_m.z()}},
           {"rotation", rotation_of(label.world_from_actor)},
           {"num_lidar_pts", seen.returns},
           {"num_radar_pts", 0}});
    }
    for (const auto& [actor, order] : of_actor) {
      const std::string name = label_class_of(main().actors[actor].kind, LabelNames::kNuscenes);
      const auto [category, is_new] = categories.emplace(name, token('C', categories.size()));
      if (is_new)
        tables_["category"].push_back({{"token", category->second}, {"name", name}, {"description", name}});
      chain(tables_["sample_annotation"], order);
      tables_["instance"].push_back({{"token", token('i', actor)},
                                     {"category_token", category->second},
                                     {"nbr_annotations", order.size()},
                                     {"first_annotation_token", token('a', order.front())},
                                     {"last_annotation_token", token('a', order.back())}});
    }
  }

  /// An actor in a sample.
  struct Seen {
    const ActorLabel* label = nullptr;
    std::size_t returns = 0, rays = 0;
    double share = 0.0;
  };
  const std::vector<LabelledFrames>& all_;
  std::size_t first_ = 0;
  std::map<std::string, Json> tables_;
  std::map<std::pair<std::size_t, std::size_t>, Seen> seen_;
};

}  // namespace

void need_label_format(const std::string& format, const std::vector<Sensor>& sensors) {
  const bool has_camera =
      std::any_of(sensors.begin(), sensors.end(), [](const Sensor& s) { return s.is_camera(); });
  if ((format == "kitti" || format == "coco") && !has_camera) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("--labels {}: found LiDARs alone, allowed with a camera; json, nuscenes", format));
  }
  if (format != "kitti" && format != "nuscenes") return;
  for (const Sensor& sensor : sensors) need_pinhole(format, sensor);
}

void write_kitti_labels(const fs::path& root, const std::vector<LabelledFrames>& all) {
  for (const auto& [name, record] : all) {
    if (!record.sensor.is_camera()) continue;
    const fs::path from = root / name, to = from / "kitti";
    for (const char* part : {"image_2", "label_2", "calib"}) fs::create_directories(to / part);
    const std::string calibration = kitti_calibration(record.sensor);
    std::string tracking;
    for (const FrameRecord& frame : record.frames) {
      const std::string number = fmt::format("{:06d}", frame.number);
      std::string objects;
      for (const ActorLabel& label : frame.labels) {
        if (label.rays == 0) continue;
        const std::string line = kitti_line(label, record.actors[label.actor].kind, record.sensor.camera());
        objects += line;
        tracking += fmt::format("{} {} {}", frame.number, label.actor, line);
      }
      also_as(from / frame.data, to / "image_2" / (number + ".png"));
      write_file_atomically(to / "label_2" / (number + ".txt"), objects);
      write_file_atomically(to / "calib" / (number + ".txt"), calibration);
    }
    write_file_atomically(to / "label_02.txt", tracking);
  }
}

void write_coco_labels(const fs::path& root, const std::vector<LabelledFrames>& all) {
  Json images = Json::array(), annotations = Json::array(), categories = Json::array();
  std::map<std::size_t, std::string> classes;
  for (const auto& [name, record] : all) {
    if (!record.sensor.is_camera()) continue;
    const Camera& camera = record.sensor.camera();
    for (const ActorRecord& actor : record.actors) classes.emplace(actor.class_id, actor.kind);
    for (const FrameRecord& frame : record.frames) {
      const std::size_t image = images.size() + 1;
      images.push_back({{"id", image},
                        {"file_name", (fs::path(name) / frame.data).generic_string()},
                        {"width", camera.width},
                        {"height", camera.height},
                        {"sensor", record.sensor.name()},
                        {"time_start_s", frame.time_start_s}});
      for (const ActorLabel& label : frame.labels) {
        if (label.rays == 0) continue;
        annotations.push_back(
            {{"id", annotations.size() + 1},
             {"image_id", image},
             {"category_id", record.actors[label.actor].class_id},
             {"iscrowd", 0},
             {"segmentation",
              {{"size", {camera.height, camera.width}}, {"counts", run_text(label.mask_runs)}}},
             {"area", label.rays},
             {"bbox", coco_box(label.visible_px)},
             {"bbox_projected", coco_box(label.projected_px)},
             {"track_id", label.actor + 1},
             {"occlusion", label.occlusion ? Json(*label.occlusion) : Json()},
             {"truncation", label.truncation}});
      }
    }
  }
  for (const auto& [id, kind] : classes)
    categories.push_back({{"id", id}, {"name", kind}, {"supercategory", kind}});
  const Json out{{"info", {{"description", "rendered by simuli"}, {"version", all.front().record.version}}},
                 {"licenses", Json::array()},
                 {"images", std::move(images)},
                 {"annotations", std::move(annotations)},
                 {"categories", std::move(categories)}};
  write_file_atomically(root / "coco.json", out.dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
}

void write_nuscenes_labels(const fs::path& root, const std::vector<LabelledFrames>& all) {
  NuscenesTables(all).write(root / "v1.0-simuli");
  fs::create_directories(root / "maps");
  Image none(1, 1, 1);  // readers require the file
  write_image(root / "maps" / "none.png", none);
}

}  // namespace simuli
