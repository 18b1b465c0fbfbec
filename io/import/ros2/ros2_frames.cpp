#include "io/import/ros2/ros2_frames.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/ros2/ros2_scan.hpp"
#include "io/log/new_log.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli::ros2 {
namespace {

void need_size(
    int width, int height, const Camera& camera, const std::string& file, const std::string& where) {
  if (width == camera.width && height == camera.height) return;
  throw_input_error(file,
                    where + ": width x height",
                    fmt::format("{} x {}", width, height),
                    fmt::format("{} x {} of its CameraInfo or --camera", camera.width, camera.height));
}

}  // namespace

FrameWriter::FrameWriter(const Bag& bag,
                         const std::string& file,
                         Log& log,
                         std::pair<std::int64_t, std::int64_t> span,
                         Ros2Report& report)
    : bag_(bag), file_(file), log_(log), span_(span), report_(report) {}

void FrameWriter::survey(const Scan& scan,
                         const std::map<std::string, RecordedLidar>& lidars,
                         const std::map<std::string, RecordedCamera>& cameras) {
  for (const auto& [topic, lidar] : lidars) {
    for (const std::int64_t ns : scan.clouds.at(topic).stamps_ns) {
      const double start_s = seconds(ns) + lidar.start_after_stamp_s, end_s = start_s + lidar.model.sweep_s;
      if (is_wanted(lidar.model.name, start_s, end_s))
        log_.sweeps.push_back({lidar.model.name, "", start_s, end_s});
    }
  }
  for (const auto& [topic, camera] : cameras) {
    for (const std::int64_t ns : scan.pictures.at(topic).stamps_ns) {
      const double start_s = seconds(ns), end_s = start_s + camera.readout_s;
      if (is_wanted(camera.name, start_s, end_s)) log_.images.push_back({camera.name, "", start_s, end_s});
    }
  }
}

void FrameWriter::write(const std::map<std::string, RecordedLidar>& lidars,
                        const std::map<std::string, RecordedCamera>& cameras,
                        const CloudFieldOptions& fields,
                        const FrameProgress& progress) {
  std::size_t done = 0;
  const auto is_requested = [&](const BagChannel& c) {
    return c.type == kPointCloud2
               ? lidars.count(c.topic) != 0
               : (c.type == kImage || c.type == kCompressedImage) && cameras.count(c.topic) != 0;
  };
  bag_.read(is_requested, [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
    ++damaged_[channel.topic].of;
    if (channel.type == kPointCloud2) {
      add_cloud(channel, data, lidars.at(channel.topic), fields);
    } else {
      add_picture(channel, data, cameras.at(channel.topic));
    }
    if (progress) progress(++done, std::max(done, total));
  });
  for (const auto& [topic, damage] : damaged_) {
    if (damage.count == damage.of) throw Error(ErrorKind::kInput, damage.first);
    if (damage.count > 0)
      report_.notes.push_back(
          fmt::format("left out: {} of {} messages of {}: {}", damage.count, damage.of, topic, damage.first));
  }
}

bool FrameWriter::is_sound(const std::string& topic, const std::function<void()>& read) {
  try {
    read();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kInput) throw;
    Damage& damage = damaged_[topic];
    if (damage.count++ == 0) damage.first = error.what();
    return false;
  }
  return true;
}

bool FrameWriter::is_wanted(const std::string& sensor, double start_s, double end_s) {
  if (!(start_s >= seconds(span_.first) && end_s <= seconds(span_.second))) {
    ++report_.unposed;
    return false;
  }
  const bool is_first = are_there_.emplace(sensor, start_s).second;
  if (!is_first) ++report_.twice;
  return is_first;
}

double FrameWriter::seconds(std::int64_t stamp_ns) const {
  constexpr double kNanosecond_s = 1e-9;
  return static_cast<double>(stamp_ns - log_.start_ns) * kNanosecond_s;
}

void FrameWriter::add_cloud(const BagChannel& channel,
                            std::string_view data,
                            const RecordedLidar& lidar,
                            const CloudFieldOptions& options) {
  double start_s = 0.0, end_s = 0.0;
  std::optional<Sweep> sweep;
  const bool is = is_sound(channel.topic, [&] {
    const PointCloudMessage cloud = read_point_cloud(reader_of(channel, data, file_));
    start_s = seconds(cloud.header.stamp_ns) + lidar.start_after_stamp_s;
    end_s = start_s + lidar.model.sweep_s;
    if (!is_wanted(lidar.model.name, start_s, end_s)) return;
    const CloudFields fields = find_cloud_fields(cloud, options, file_, channel.topic);
    const std::vector<CloudPoint> points = points_of(cloud, fields, file_, channel.topic);
    sweep = grid_points(measured(points, lidar, file_, channel.topic), lidar.model, report_.points);
  });
  if (!is || !sweep) return;
  LogMaker(log_, {}, 0)
      .add_sweep(lidar.model.name,
                 fmt::format("{}_{:06d}", lidar.model.name, report_.sweeps++),
                 *sweep,
                 {start_s, end_s});
}

void FrameWriter::add_picture(const BagChannel& channel,
                              std::string_view data,
                              const RecordedCamera& camera) {
  const Camera& model = log_.camera(camera.name).model;
  std::int64_t stamp_ns = 0;
  Image image;
  std::string_view bytes;
  std::string ending = ".png";
  const bool is = is_sound(channel.topic, [&] {
    if (channel.type == kImage) {
      const ImageMessage message = read_image_message(reader_of(channel, data, file_));
      image = picture_of(message, file_, channel.topic);
      need_size(image.width, image.height, model, file_, channel.topic);
      stamp_ns = message.header.stamp_ns;
    } else {
      const CompressedImageMessage message = read_compressed_image(reader_of(channel, data, file_));
      stamp_ns = message.header.stamp_ns;
      bytes = message.data;
      ending = picture_ending(message);
      if (ending.empty())
        throw_input_error(file_,
                          channel.topic + ": data",
                          fmt::format("none of these, called \"{}\"", message.format),
                          "JPEG, PNG or WebP");
    }
  });
  const double start_s = seconds(stamp_ns), end_s = start_s + camera.readout_s;
  if (!is || !is_wanted(camera.name, start_s, end_s)) return;
  const std::string name = fmt::format("images/{}_{:06d}{}", camera.name, report_.pictures, ending);
  bool is_whole = true;
  put_file(log_, name, [&](const std::filesystem::path& path) {
    if (channel.type == kImage) return write_image(path, image);
    write_file_atomically(path, std::string(bytes));
    is_whole = is_sound(channel.topic, [&] {
      (void)with_context(fmt::format("reading a picture of {} in {}", channel.topic, file_), [&] {
        return read_image(
            path, [&](int width, int height) { need_size(width, height, model, file_, channel.topic); });
      });
    });
    if (!is_whole) std::filesystem::remove(path);
  });
  if (!is_whole) return;
  ++report_.pictures;
  log_.images.push_back({camera.name, name, start_s, end_s});
}

std::string picture_ending(const CompressedImageMessage& message) {
  return message.data.starts_with("\x89PNG")        ? ".png"
         : message.data.starts_with("\xff\xd8\xff") ? ".jpg"
         : message.data.starts_with("RIFF")         ? ".webp"
                                                    : "";
}

}  // namespace simuli::ros2
