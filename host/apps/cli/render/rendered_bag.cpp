#include "host/apps/cli/render/rendered_bag.hpp"

#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"

namespace simuli::cli {
namespace {

BagPictures pictures_of(const std::string& images) {
  if (images == "raw") return BagPictures::kRaw;
  return images == "jpeg" ? BagPictures::kJpeg : BagPictures::kPng;
}

void refuse_of_bag(const char* option, const std::string& found, const char* allowed) {
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: found \"{}\" for an .mcap file, allowed {}", option, found, allowed));
}

}  // namespace

bool is_bag(const std::filesystem::path& file) { return ending_of(file) == ".mcap"; }

void need_options_of_bags(const FileOptions& options) {
  const FileOptions usual;
  if (options.images == "exr") refuse_of_bag("--images", options.images, "png, jpeg, raw");
  if (options.outputs != usual.outputs) refuse_of_bag("--outputs", options.outputs, "rgb");
  if (options.clouds != usual.clouds)
    refuse_of_bag("--clouds", options.clouds, "with a folder: it is PointCloud2");
  if (options.cloud_frame == "world")
    refuse_of_bag("--cloud-frame", options.cloud_frame, "sensor, sensor_start");
}

RenderedBag::RenderedBag(const std::filesystem::path& file, Ros2Drive drive, const FileOptions& options)
    : recording_(file,
                 std::move(drive),
                 has_zstd() ? McapWriter::Compression::kZstd : McapWriter::Compression::kNone),
      pictures_(pictures_of(options.images)) {
  cloud_.frame = options.cloud_frame.empty() ? PointFrame::kSensor : point_frame(options.cloud_frame);
}

void RenderedBag::add(const Frame& frame, const RecordedViews* recorded) {
  const Sensor& sensor = frame.sensor();
  const double start_s = frame.shot().time_start_s;
  if (sensor.is_camera()) {
    recording_.add_picture(sensor.name(), start_s, shown(frame, recorded), pictures_);
  } else {
    recording_.add_cloud(sensor.name(), start_s, point_cloud(frame, cloud_));
  }
}

}  // namespace simuli::cli
