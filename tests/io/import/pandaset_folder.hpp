#pragma once
// Tables in the pickle format of pandas, and a synthetic sequence of PandaSet.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "io/base/gzip.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/pandaset/pandaset_parts.hpp"
#include "io/picture/image.hpp"

namespace simuli::test {

/// Writes the operations of a pickle.
class PickleText {
 public:
  std::string bytes = "\x80\x03";

  PickleText& put(std::string_view operations) {
    bytes += operations;
    return *this;
  }
  PickleText& counted(char operation, std::string_view content) {
    bytes += operation;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(content.size() >> (8 * i) & 255U);
    return put(content);
  }
  PickleText& text(std::string_view content) { return counted('X', content); }
  PickleText& integer(std::int32_t value) {
    bytes += 'J';
    for (int i = 0; i < 4; ++i)
      bytes += static_cast<char>(static_cast<std::uint32_t>(value) >> (8 * i) & 255U);
    return *this;
  }
  PickleText& global(std::string_view module, std::string_view name) {
    return put(fmt::format("c{}\n{}\n", module, name));
  }
  /// Writes an array of `type` as NumPy does; `content` writes its bytes or values.
  template <class Content>
  PickleText& array(const std::vector<std::size_t>& shape, std::string_view type, const Content& content) {
    global("numpy.core.multiarray", "_reconstruct").global("numpy", "ndarray");
    integer(0)
        .put("\x85")
        .put(std::string("C\x01"
                         "b",
                         3))
        .put("\x87R(")
        .integer(1)
        .put("(");
    for (const std::size_t side : shape) integer(static_cast<std::int32_t>(side));
    put("t").global("numpy", "dtype").text(type).integer(0).integer(1).put("\x87R(").integer(3).text("<");
    put("NNN").integer(-1).integer(-1).integer(0).put("tb\x89");
    content();
    return put("tb");
  }
  PickleText& texts(const std::vector<std::size_t>& shape, const std::vector<std::string>& values) {
    return array(shape, "O8", [&] {
      put("](");
      for (const std::string& value : values) text(value);
      put("e");
    });
  }
  PickleText& slice(std::size_t from, std::size_t to) {
    global("builtins", "slice")
        .integer(static_cast<std::int32_t>(from))
        .integer(static_cast<std::int32_t>(to));
    return integer(1).put("\x87R");
  }
};

/// Columns of numbers, then of texts.
struct MadeTable {
  std::vector<std::pair<std::string, std::vector<double>>> numbers;
  std::vector<std::pair<std::string, std::vector<std::string>>> texts;

  [[nodiscard]] std::size_t rows() const { return numbers.empty() ? 0 : numbers[0].second.size(); }
  /// Returns the pickle in the format of the data set, or of pandas 2.
  [[nodiscard]] std::string pickled(bool is_old = true) const {
    PickleText p;
    const auto values = [&](bool are_texts) {
      if (are_texts) {
        std::vector<std::string> all;
        for (const auto& [name, column] : texts) all.insert(all.end(), column.begin(), column.end());
        p.texts({texts.size(), rows()}, all);
        return;
      }
      p.array({numbers.size(), rows()}, "f8", [&] {
        std::string all;
        for (const auto& [name, column] : numbers)
          all.append(reinterpret_cast<const char*>(column.data()), column.size() * sizeof(double));
        p.counted('B', all);
      });
    };
    const auto axes = [&] {
      std::vector<std::string> names;
      for (const auto& [name, column] : numbers) names.push_back(name);
      for (const auto& [name, column] : texts) names.push_back(name);
      p.put("](")
          .global("pandas.core.indexes.base", "_new_Index")
          .global("pandas.core.indexes.base", "Index");
      p.put("}(").text("data").texts({names.size()}, names).text("name").put("Nu\x86R");
      p.global("pandas.core.indexes.base", "_new_Index").global("pandas.core.indexes.range", "RangeIndex");
      p.put("}(")
          .text("start")
          .integer(0)
          .text("stop")
          .integer(static_cast<std::int32_t>(rows()))
          .put("u\x86R");
      p.put("e");
    };
    const std::size_t count = numbers.size(), all = count + texts.size();
    p.global("pandas.core.frame", "DataFrame").put(")\x81}(").text(is_old ? "_data" : "_mgr");
    p.global("pandas.core.internals.managers", "BlockManager");
    if (is_old) {
      p.put(")\x81(]]]}").text("0.14.1").put("}(").text("axes");
      axes();
      p.text("blocks").put("](}(").text("values");
      values(false);
      p.text("mgr_locs").slice(0, count).put("u");
      if (!texts.empty()) {
        p.put("}(").text("values");
        values(true);
        p.text("mgr_locs").slice(count, all).put("u");
      }
      p.put("eustb");
    } else {
      p.put("(");
      for (const bool are_texts : {false, true}) {
        if (are_texts && texts.empty()) continue;
        p.global("pandas._libs.internals", "_unpickle_block");
        values(are_texts);
        p.slice(are_texts ? count : 0, are_texts ? all : count).integer(2).put("\x87R");
      }
      p.put("t");
      axes();
      p.put("\x86R");
    }
    return p.text("_typ").text("dataframe").put("ub.").bytes;
  }
};

/// A drive along x at 10 m/s with three frames: two cameras (8 x 6 pixels, the rear one points backwards),
/// the Pandar64 in a tower at a constant distance of 12 m, every tenth column, and some points of the
/// PandarGT. The second and the third frame have the same points of the PandarGT. Boxes: a car without
/// points; and one around the Pandar64's point in the middle of its sweep, labelled twice, except for the
/// last frame, which only has the PandarGT's label.
class MadeSequence {
 public:
  static constexpr std::size_t kFrames = 3;
  static constexpr int kColumns = 180;
  static constexpr double kStart_s = 1.6e9, kTower_m = 12.0, kFirst_rad = 2.0;

  /// `published_from_rows`: pose of the Pandar64's beams, which the files do not contain.
  explicit MadeSequence(const std::filesystem::path& root, const Pose& published_from_rows = {})
      : root_(root), published_from_rows_(published_from_rows) {
    for (const char* folder : {"camera/front_camera", "camera/back_camera", "lidar", "annotations/cuboids"})
      std::filesystem::create_directories(root / folder);
    camera("front_camera", 0.05, pandaset::camera_from_pandar64().inverse());
    camera("back_camera", 0.05, rear());
    for (std::size_t i = 0; i < kFrames; ++i) {
      write(fmt::format("lidar/{:02}.pkl.gz", i), gzip(points(i).pickled(i != 1)));
      write(fmt::format("annotations/cuboids/{:02}.pkl.gz", i), gzip(labels(i).pickled(i == 1)));
    }
  }

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(root_ / name, std::ios::binary) << bytes;
  }
  /// Returns the pose of the Pandar64 in the data set's world.
  static Pose pandar64_at(double time_s) {
    const Pose theirs{Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ())),
                      {100.0, -50.0, 3.0}};
    return theirs * Pose{Eigen::Quaterniond::Identity(), {10.0 * time_s, 0.0, 0.0}} *
           pandaset::rig_from_pandar64();
  }
  /// Returns the pose of the rear camera on the Pandar64: it points along the vehicle's -x.
  static Pose rear() {
    Eigen::Matrix3d axes;
    axes << -1, 0, 0, 0, 0, 1, 0, -1, 0;
    return {Eigen::Quaterniond(axes), {0.2, 1.0, -0.1}};
  }
  static double column_s(int column) { return 0.1 * (column + 0.5) / kColumns; }
  /// Returns a direction in the frame of the Pandar64.
  static Eigen::Vector3d direction(int row, int column) {
    const double azimuth = kFirst_rad - 2.0 * std::numbers::pi * (column + 0.5) / kColumns;
    return Lidar::direction(azimuth, table().rows[static_cast<std::size_t>(row)].elevation);
  }

 private:
  static const Lidar& table() {
    static const Lidar lidar = builtin_lidar("ncore_pandaset_pandar64");
    return lidar;
  }

  void camera(const std::string& name, double after_s, const Pose& pandar64_from_camera) const {
    Json times = Json::array(), poses = Json::array();
    for (std::size_t i = 0; i < kFrames; ++i) {
      const double time_s = 0.1 * static_cast<double>(i) + after_s;
      const Pose pose = pandar64_at(time_s) * pandar64_from_camera;
      times.push_back(kStart_s + time_s);
      poses.push_back(
          {{"position",
            {{"x", pose.translation.x()}, {"y", pose.translation.y()}, {"z", pose.translation.z()}}},
           {"heading",
            {{"w", pose.rotation.w()},
             {"x", pose.rotation.x()},
             {"y", pose.rotation.y()},
             {"z", pose.rotation.z()}}}});
      write_image(root_ / "camera" / name / fmt::format("{:02}.jpg", i), Image(8, 6, 3));
    }
    write("camera/" + name + "/timestamps.json", times.dump());
    write("camera/" + name + "/poses.json", poses.dump());
    write("camera/" + name + "/intrinsics.json", R"({"fx": 9.0, "fy": 9.0, "cx": 3.5, "cy": 2.5})");
  }

  [[nodiscard]] MadeTable points(std::size_t frame) const {
    MadeTable out{{{"x", {}}, {"y", {}}, {"z", {}}, {"i", {}}, {"t", {}}, {"d", {}}}, {}};
    const auto add = [&](const Eigen::Vector3d& world, double intensity, double time_s, double source) {
      const double values[] = {world.x(), world.y(), world.z(), intensity, kStart_s + time_s, source};
      for (std::size_t k = 0; k < 6; ++k) out.numbers[k].second.push_back(values[k]);
    };
    for (int row = 0; row < table().row_count(); ++row) {
      for (int c = 0; c < kColumns; ++c) {
        const double time_s = 0.1 * static_cast<double>(frame) + column_s(c);
        const Pose sensor = pandar64_at(time_s) * published_from_rows_;
        add(sensor * (kTower_m * direction(row, c)), 51.0, time_s, 0.0);
      }
    }
    const std::size_t own = frame == 0 ? 10 : 8;
    for (std::size_t i = 0; i < own; ++i) {
      const double time_s = (frame == 0 ? 0.0 : 0.1) + 0.01 * static_cast<double>(i);
      const Pose sensor = pandar64_at(time_s) * pandaset::pandar64_from_pandargt();
      add(sensor * (20.0 * Lidar::direction(1.5 + 0.01 * static_cast<double>(i), 0.05)), 255.0, time_s, 1.0);
    }
    return out;
  }

  static MadeTable labels(std::size_t frame) {
    MadeTable out{{{"yaw", {}},
                   {"position.x", {}},
                   {"position.y", {}},
                   {"position.z", {}},
                   {"dimensions.x", {}},
                   {"dimensions.y", {}},
                   {"dimensions.z", {}},
                   {"cuboids.sensor_id", {}}},
                  {{"uuid", {}}, {"label", {}}, {"cuboids.sibling_id", {}}}};
    const auto add =
        [&](const std::string& id, const std::string& sibling, int sensor, const Eigen::Vector3d& at) {
          const double values[] = {0.8, at.x(), at.y(), at.z(), 1.0, 1.5, 2.0, static_cast<double>(sensor)};
          for (std::size_t k = 0; k < 8; ++k) out.numbers[k].second.push_back(values[k]);
          const std::string texts[] = {id, sensor < 0 ? "Car" : "Pedestrian with Object", sibling};
          for (std::size_t k = 0; k < 3; ++k) out.texts[k].second.push_back(texts[k]);
        };
    add("parked", "-", -1, {500.0, 0.0, 3.0});
    const double time_s = 0.1 * static_cast<double>(frame) + column_s(kColumns / 2);
    const Eigen::Vector3d middle = pandar64_at(time_s) * (kTower_m * direction(30, kColumns / 2));
    if (frame + 1 < kFrames) add("walker", "again", 0, middle);
    add("again", "walker", 1, middle + Eigen::Vector3d(0.0, 0.0, 0.1));
    return out;
  }

  std::filesystem::path root_;
  Pose published_from_rows_;
};

}  // namespace simuli::test
