#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/photos/photo_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastViews = 3;  // per point

/// A camera model of COLMAP: f or fx fy, cx cy, then the lens's parameters.
struct Model {
  const char* name;
  std::size_t parameters;
  std::size_t focals;
  LensKind lens;
};
constexpr std::array<Model, 11> kModels{
    {{"SIMPLE_PINHOLE", 3, 1, LensKind::kPinhole},
     {"PINHOLE", 4, 2, LensKind::kPinhole},
     {"SIMPLE_RADIAL", 4, 1, LensKind::kOpencvPinhole},
     {"RADIAL", 5, 1, LensKind::kOpencvPinhole},
     {"OPENCV", 8, 2, LensKind::kOpencvPinhole},
     {"OPENCV_FISHEYE", 8, 2, LensKind::kOpencvFisheye},
     {"FULL_OPENCV", 12, 2, LensKind::kOpencvPinhole},
     {"FOV", 5, 2, LensKind::kPinhole},  // refused: unsupported lens
     {"SIMPLE_RADIAL_FISHEYE", 4, 1, LensKind::kOpencvFisheye},
     {"RADIAL_FISHEYE", 5, 1, LensKind::kOpencvFisheye},
     {"THIN_PRISM_FISHEYE", 12, 2, LensKind::kPinhole}}};  // refused as FOV
constexpr std::size_t kFov = 7, kThinPrism = 10;

/// Reads values from a binary file in sequence.
class Bytes {
 public:
  explicit Bytes(const fs::path& file) : file_(file.string()), bytes_(read_file(file)) {}

  template <class T>
  T next() {
    T value{};
    need(sizeof(T));
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) need(bytes_.size());
    std::string out = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return out;
  }
  void skip(std::uint64_t count, std::size_t size) {
    if (count > (bytes_.size() - at_) / size) need(bytes_.size());
    at_ += count * size;
  }
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  void need(std::size_t count) const {
    if (count > bytes_.size() - at_) throw_input_error(file_, "content", "its end", "a whole COLMAP file");
  }
  std::string file_, bytes_;
  std::size_t at_ = 0;
};

Camera make_camera(const std::string& file,
                   std::int64_t id,
                   std::size_t model,
                   const std::string& model_name,
                   std::uint64_t width,
                   std::uint64_t height,
                   const std::vector<double>& p) {
  if (model >= kModels.size() || model == kFov || model == kThinPrism) {
    throw_input_error(file,
                      fmt::format("camera {}: model", id),
                      model_name,
                      "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE, "
                      "SIMPLE_RADIAL_FISHEYE or RADIAL_FISHEYE");
  }
  constexpr std::uint64_t kLargest = 65536;
  const Model& m = kModels[model];
  Camera c;
  c.name = fmt::format("camera_{}", id);
  c.width = static_cast<int>(std::min(width, kLargest + 1));  // validate() refuses larger ones
  c.height = static_cast<int>(std::min(height, kLargest + 1));
  c.fx = p[0];
  c.fy = p[m.focals - 1];
  c.cx = p[m.focals];
  c.cy = p[m.focals + 1];
  std::vector<double> lens(p.begin() + static_cast<std::ptrdiff_t>(m.focals + 2), p.end());
  if (m.lens != LensKind::kPinhole) {
    lens.resize(lens_parameter_names(m.lens).size(), 0.0);
    lens.back() = std::numbers::pi;  // max_angle_rad: the lens's full range
    c.lens = Lens(m.lens, lens, fmt::format("{}: camera {}", file, id));
  }
  validate(c, file);
  return c;
}

/// Returns the lines without comments.
std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream in(read_file(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.starts_with('#')) lines.push_back(line);
  }
  return lines;
}

bool is_blank(const std::string& line) { return line.find_first_not_of(" \t") == std::string::npos; }

[[noreturn]] void refuse_line(const fs::path& file, const std::string& line, const char* allowed) {
  throw_input_error(file.string(), "line", '"' + line.substr(0, 60) + '"', allowed);
}

std::map<std::int64_t, Camera> read_cameras(const fs::path& folder, bool binary) {
  std::map<std::int64_t, Camera> cameras;
  if (binary) {
    Bytes in(folder / "cameras.bin");
    for (auto left = in.next<std::uint64_t>(); left > 0; --left) {
      const auto id = in.next<std::int32_t>();
      const auto model = static_cast<std::size_t>(in.next<std::int32_t>());
      const auto width = in.next<std::uint64_t>(), height = in.next<std::uint64_t>();
      std::vector<double> p;
      const std::string name = model < kModels.size() ? kModels[model].name : fmt::format("number {}", model);
      const std::size_t count = model < kModels.size() ? kModels[model].parameters : 0;
      while (p.size() < count) p.push_back(in.next<double>());
      cameras[id] = make_camera(in.file(), id, model, name, width, height, p);
    }
    return cameras;
  }
  const fs::path file = folder / "cameras.txt";
  for (const std::string& line : lines_of(file)) {
    if (is_blank(line)) continue;
    std::istringstream in(line);
    std::int64_t id = 0;
    std::string name;
    std::uint64_t width = 0, height = 0;
    std::vector<double> p;
    const bool is_camera = static_cast<bool>(in >> id >> name >> width >> height);
    for (double value = 0.0; in >> value;) p.push_back(value);
    const auto known =
        std::find_if(kModels.begin(), kModels.end(), [&](const Model& m) { return name == m.name; });
    const auto model = static_cast<std::size_t>(known - kModels.begin());
    if (!is_camera || (known != kModels.end() && (p.size() != known->parameters || !in.eof()))) {
      refuse_line(file, line, "CAMERA_ID MODEL WIDTH HEIGHT and the model's parameters");
    }
    cameras[id] = make_camera(file.string(), id, model, name, width, height, p);
  }
  return cameras;
}

struct Posed {
  std::string name;
  std::int64_t camera = 0;
  Pose world_from_camera;
};

/// Returns no value without a rotation, and for a non-finite one.
std::optional<Posed> make_posed(std::string name, std::int64_t camera, const std::array<double, 7>& v) {
  const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
  const Pose camera_from_world{q.normalized(), {v[4], v[5], v[6]}};
  if (!(q.norm() > 0.5 && q.norm() < 2.0) || !camera_from_world.translation.allFinite()) return {};
  return Posed{std::move(name), camera, camera_from_world.inverse()};
}

/// Whether a line consists of triples of numbers. An image's own line has ten words, the last one a name.
bool holds_observations(const std::string& line) {
  if (line.find_first_not_of("0123456789+-.eE \t") != std::string::npos) return false;
  std::istringstream in(line);
  return std::distance(std::istream_iterator<std::string>(in), {}) % 3 == 0;
}

std::vector<Posed> read_images(const fs::path& folder, bool binary, std::size_t& unposed) {
  std::vector<Posed> images;
  const auto add = [&](std::optional<Posed> image) {
    image ? images.push_back(std::move(*image)) : static_cast<void>(++unposed);
  };
  std::array<double, 7> v{};
  if (binary) {
    Bytes in(folder / "images.bin");
    for (auto left = in.next<std::uint64_t>(); left > 0; --left) {
      (void)in.next<std::int32_t>();
      for (double& value : v) value = in.next<double>();
      const auto camera = in.next<std::int32_t>();
      std::string name = in.text();
      in.skip(in.next<std::uint64_t>(), 24);  // x, y, point id of the observations
      add(make_posed(std::move(name), camera, v));
    }
    return images;
  }
  const fs::path file = folder / "images.txt";
  const std::vector<std::string> lines = lines_of(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (is_blank(lines[i])) continue;
    std::istringstream in(lines[i]);
    std::int64_t id = 0, camera = 0;
    in >> id;
    for (double& value : v) in >> value;
    in >> camera >> std::ws;
    std::string name;
    if (!std::getline(in, name)) {
      refuse_line(file, lines[i], "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    }
    name.erase(name.find_last_not_of(" \t\r") + 1);
    add(make_posed(std::move(name), camera, v));
    // The next line, possibly blank, contains the observations.
    if (++i < lines.size() && !holds_observations(lines[i]))
      refuse_line(
          file, lines[i], "X Y POINT3D_ID of points, or a blank line, behind each image's first line");
  }
  return images;
}

std::vector<Eigen::Vector3d> read_points(const fs::path& folder, bool binary) {
  std::vector<Eigen::Vector3d> points;
  const fs::path file = folder / (binary ? "points3D.bin" : "points3D.txt");
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return points;
  std::vector<Eigen::Vector3d> untracked;
  bool has_tracks = false;
  const auto add = [&](const Eigen::Vector3d& p, std::size_t views) {
    has_tracks = has_tracks || views > 0;
    if (!p.allFinite()) return;
    if (views >= kLeastViews) points.push_back(p);
    if (!has_tracks) untracked.push_back(p);
  };
  if (binary) {
    Bytes in(file);
    for (auto left = in.next<std::uint64_t>(); left > 0; --left) {
      (void)in.next<std::uint64_t>();
      Eigen::Vector3d p;
      for (int i = 0; i < 3; ++i) p[i] = in.next<double>();
      in.skip(11, 1);  // colour and error
      const auto views = in.next<std::uint64_t>();
      in.skip(views, 8);
      add(p, views);
    }
    return has_tracks ? points : untracked;
  }
  for (const std::string& line : lines_of(file)) {
    if (is_blank(line)) continue;
    std::istringstream in(line);
    std::uint64_t id = 0;
    Eigen::Vector3d p;
    double unused = 0.0;
    if (!(in >> id >> p.x() >> p.y() >> p.z())) refuse_line(file, line, "POINT3D_ID X Y Z R G B ERROR TRACK");
    std::size_t numbers = 0;
    while (in >> unused) ++numbers;
    add(p, numbers > 4 ? (numbers - 4) / 2 : 0);
  }
  return has_tracks ? points : untracked;
}

bool holds_model(const fs::path& folder, const char* ending) {
  std::error_code ignored;
  return fs::exists(folder / (std::string("cameras.") + ending), ignored) &&
         fs::exists(folder / (std::string("images.") + ending), ignored);
}

fs::path find_images(const fs::path& model, const fs::path& requested) {
  if (!requested.empty()) return requested;
  std::error_code ignored;
  fs::path folder = (fs::current_path() / model).lexically_normal();
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    if (fs::is_directory(folder / "images", ignored)) return folder / "images";
  }
  throw_input_error(model.string(), "photographs", "no folder images near it", "--images FOLDER");
}

}  // namespace

PhotoSet read_colmap(const ColmapOptions& options) {
  fs::path folder;
  bool binary = false;
  for (const char* below : {"", "sparse/0", "sparse"}) {
    const fs::path candidate = options.model / below;
    if (!holds_model(candidate, "bin") && !holds_model(candidate, "txt")) continue;
    folder = candidate;
    binary = holds_model(candidate, "bin");
    break;
  }
  if (folder.empty()) {
    throw_input_error(options.model.string(), "COLMAP model", "none", "cameras and images, .bin or .txt");
  }
  PhotoSet set;
  set.source = (folder / (binary ? "images.bin" : "images.txt")).string();
  set.level = true;
  std::map<std::int64_t, std::size_t> index;
  for (auto& [id, camera] : read_cameras(folder, binary)) {
    index[id] = set.cameras.size();
    set.cameras.push_back(camera);
  }
  std::size_t unposed = 0;
  std::vector<Posed> images = read_images(folder, binary, unposed);
  if (unposed > 0) set.notes.push_back(fmt::format("{} photographs without a pose are left out", unposed));
  std::stable_sort(
      images.begin(), images.end(), [](const Posed& a, const Posed& b) { return is_before(a.name, b.name); });
  const fs::path photos = find_images(folder, options.images);
  for (const Posed& image : images) {
    const auto camera = index.find(image.camera);
    if (camera == index.end()) {
      throw_input_error(
          set.source, "camera of " + image.name, fmt::format("{}", image.camera), "one of cameras");
    }
    set.photos.push_back(
        {inside(photos, image.name, set.source, "NAME"), camera->second, image.world_from_camera});
  }
  set.points = read_points(folder, binary);
  return set;
}

Log import_colmap(const ColmapOptions& options, const FrameProgress& progress, PhotoReport& report) {
  return write_photo_log(read_colmap(options), options.metres_per_unit, options.output, progress, report);
}

}  // namespace simuli
