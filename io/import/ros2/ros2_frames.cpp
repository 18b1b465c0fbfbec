#include "io/import/ros2/ros2_frames.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/ros2/ros2_scan.hpp"
#include "io/picture/image.hpp"

namespace simuli::ros2 {
namespace {

void need_size(const Image& image, const Camera& camera, const std::string& file, const std::string& where) {
  if (image.width == camera.width && image.height == camera.height) return;
  throw_input_error(file,
                    where + ": width x height",
                    fmt::format("{} x {}", image.width, image.height),
                    fmt::format("{} x {} of its CameraInfo or --camera", camera.width, camera.height));
}

}  // namespace

FrameWriter::FrameWriter(const Bag& bag,
                         const std::string& file,
                         Log& log,
                         const std::filesystem::path& folder,
                         std::pair<std::int64_t, std::int64_t> span,
                         Ros2Report& report)
    : bag_(bag), file_(file), log_(log), folder_(folder), span_(span), report_(report) {
  std::filesystem::create_directory(folder_ / "images");
  std::filesystem::create_directory(folder_ / "sweeps");
}

void FrameWriter::write(const std::map<std::string, RecordedLidar>& lidars,
                        const std::map<std::string, RecordedCamera>& cameras,
                        const CloudFieldOptions& fields,
                        const std::function<void(std::size_t, std::size_t)>& progress) {
  std::size_t done = 0;
  const auto is_wanted = [&](const BagChannel& c) {
    return c.type == kPointCloud2
               ? lidars.count(c.topic) != 0
               : (c.type == kImage || c.type == kCompressedImage) && cameras.count(c.topic) != 0;
  };
  bag_.read(is_wanted, [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
    if (channel.type == kPointCloud2) {
      add_cloud(channel, data, lidars.at(channel.topic), fields);
    } else {
      add_picture(channel, data, cameras.at(channel.topic));
    }
    if (progress) progress(++done, std::max(done, total));
  });
}

bool FrameWriter::is_on_path(double start_s, double end_s) {
  const bool is = start_s >= seconds(span_.first) && end_s <= seconds(span_.second);
  if (!is) ++report_.unposed;
  return is;
}

double FrameWriter::seconds(std::int64_t stamp_ns) const {
  constexpr double kNanosecond_s = 1e-9;
  return static_cast<double>(stamp_ns - log_.start_ns) * kNanosecond_s;
}

void FrameWriter::add_cloud(const BagChannel& channel,
                            std::string_view data,
                            const RecordedLidar& lidar,
                            const CloudFieldOptions& options) {
  const PointCloudMessage cloud = read_point_cloud(reader_of(channel, data, file_));
  const double start_s = seconds(cloud.header.stamp_ns) + lidar.start_after_stamp_s;
  const double end_s = start_s + lidar.model.sweep_s;
  if (!is_on_path(start_s, end_s)) return;
  const CloudFields fields = find_cloud_fields(cloud, options, file_, channel.topic);
  const std::vector<CloudPoint> points = points_of(cloud, fields, file_, channel.topic);
  const Sweep sweep = grid_points(measured(points, lidar, file_, channel.topic), lidar.model, report_.points);
  log_.sweeps.push_back({lidar.model.name,
                         fmt::format("sweeps/{}_{:06d}.exr", lidar.model.name, report_.sweeps++),
                         start_s,
                         end_s});
  write_sweep(folder_ / log_.sweeps.back().file, sweep);
}

void FrameWriter::add_picture(const BagChannel& channel,
                              std::string_view data,
                              const RecordedCamera& camera) {
  const Camera& model = log_.camera(camera.name).model;
  const auto add = [&](std::int64_t stamp_ns, const char* ending) {
    const double start_s = seconds(stamp_ns);
    if (!is_on_path(start_s, start_s + camera.readout_s)) return std::filesystem::path();
    log_.images.push_back({camera.name,
                           fmt::format("images/{}_{:06d}{}", camera.name, report_.pictures++, ending),
                           start_s,
                           start_s + camera.readout_s});
    return folder_ / log_.images.back().file;
  };
  if (channel.type == kImage) {
    const ImageMessage message = read_image_message(reader_of(channel, data, file_));
    const Image image = picture_of(message, file_, channel.topic);
    need_size(image, model, file_, channel.topic);
    const std::filesystem::path path = add(message.header.stamp_ns, ".png");
    if (!path.empty()) write_image(path, image);
    return;
  }
  const CompressedImageMessage message = read_compressed_image(reader_of(channel, data, file_));
  const char* const ending = message.data.starts_with("\x89PNG")        ? ".png"
                             : message.data.starts_with("\xff\xd8\xff") ? ".jpg"
                             : message.data.starts_with("RIFF")         ? ".webp"
                                                                        : nullptr;
  if (ending == nullptr)
    throw_input_error(file_,
                      channel.topic + ": data",
                      fmt::format("none of these, called \"{}\"", message.format),
                      "JPEG, PNG or WebP");
  const std::filesystem::path path = add(message.header.stamp_ns, ending);
  if (path.empty()) return;
  write_file_atomically(path, std::string(message.data));
  const Image image = with_context(fmt::format("reading a picture of {} in {}", channel.topic, file_),
                                   [&] { return read_image(path); });
  need_size(image, model, file_, channel.topic);
}

}  // namespace simuli::ros2
