#include "bench/paper/drive_log.hpp"

#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/import/kitti/kitti.hpp"
#include "io/synth/street.hpp"
#include "optim/train/training_options.hpp"

namespace simuli::bench {
namespace {

namespace fs = std::filesystem;

/// Parts of "FOLDER,poses=FILE,labels=FILE,KEY=VALUE".
struct DriveText {
  fs::path folder, poses, labels;
  std::vector<std::string> settings;  // of the drive's training
};

DriveText parts_of(const std::string& text) {
  DriveText parts;
  std::size_t comma = text.find(',');
  parts.folder = text.substr(0, comma);
  while (comma != std::string::npos) {
    const std::size_t begin = comma + 1;
    comma = text.find(',', begin);
    const std::string part = text.substr(begin, comma == std::string::npos ? comma : comma - begin);
    const std::size_t equals = part.find('=');
    const auto refuse = [&](const std::string& why) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("drive {}: found {}, allowed poses=FILE, labels=FILE, a setting's KEY=VALUE{}",
                      parts.folder.string(),
                      part,
                      why));
    };
    if (equals == std::string::npos || equals + 1 == part.size()) refuse("");
    const std::string key = part.substr(0, equals);
    if (key == "poses" || key == "labels") {
      (key == "poses" ? parts.poses : parts.labels) = part.substr(equals + 1);
      continue;
    }
    try {
      (void)training_options("", {part});
    } catch (const Error& error) {
      refuse(fmt::format(" ({})", error.what()));
    }
    parts.settings.push_back(part);
  }
  return parts;
}

Log imported(const DriveText& parts, const fs::path& scratch) {
  KittiOptions options;
  options.drive = parts.folder;
  options.poses = parts.poses;
  options.tracking = parts.labels;
  options.output = scratch / (drive_name(parts.folder) + ".log");
  return import_kitti(options);
}

}  // namespace

std::string drive_name(const fs::path& folder) {
  fs::path bare = folder.lexically_normal();
  if (!bare.has_filename()) bare = bare.parent_path();
  std::string name = bare.filename().string();
  constexpr std::string_view kMark = "_drive_";
  const std::size_t mark = name.find(kMark);
  if (mark != std::string::npos) {
    const std::size_t begin = mark + kMark.size();
    const std::size_t end = name.find_first_not_of("0123456789", begin);
    if (end != begin) return name.substr(begin, end == std::string::npos ? end : end - begin);
  }
  return bare.extension() == ".log" ? bare.stem().string() : name;
}

Drive open_drive(const std::string& text, const fs::path& scratch) {
  if (text == "street") {
    StreetOptions street;
    street.output = scratch / "street.log";
    return {"street", synth_street(street), {"image_scale=1", "iterations=400"}};
  }
  const DriveText parts = parts_of(text);
  const bool is_log = fs::exists(parts.folder / "log.json");
  if (is_log && parts.poses.empty() && parts.labels.empty()) {
    return {drive_name(parts.folder), read_log(parts.folder), parts.settings};
  }
  if (!is_log && fs::is_directory(parts.folder / "velodyne_points")) {
    return {drive_name(parts.folder), imported(parts, scratch), parts.settings};
  }
  throw Error(
      ErrorKind::kUsage,
      fmt::format("drive {}: found {}, allowed street, a log folder, or a drive of KITTI raw with its "
                  "velodyne_points, which alone takes poses and labels",
                  text,
                  is_log ? "a log" : "neither log.json nor velodyne_points"));
}

}  // namespace simuli::bench
