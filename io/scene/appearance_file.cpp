#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/picture/sized_image.hpp"
#include "io/scene/scene_parts.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnvironmentName = "environment.exr";
constexpr const char* kGridsName = "color_grids.exr";
constexpr std::int64_t kMostTexels = 16384;  // per side
constexpr std::int64_t kMostVertices = 64;   // per axis
constexpr std::size_t kAcross = 8;           // grids per row of the picture
constexpr int kColumns = 4;                  // of a transform

/// Positions of the grids' values in their picture.
struct GridPicture {
  explicit GridPicture(const ColorGrids& g)
      : grids(g),
        across(std::min(kAcross, std::max<std::size_t>(1, g.frames.size()))),
        width(static_cast<int>(across) * g.size_x * g.size_z * kColumns),
        height(static_cast<int>((g.frames.size() + across - 1) / across) * g.size_y) {}

  /// Calls visit(index into values, index into the picture's data) for every value.
  template <class Visit>
  void each(Visit&& visit) const {
    std::size_t value = 0;
    for (std::size_t frame = 0; frame < grids.frames.size(); ++frame) {
      const int left = static_cast<int>(frame % across) * grids.size_x * grids.size_z * kColumns;
      const int top = static_cast<int>(frame / across) * grids.size_y;
      for (int y = 0; y < grids.size_y; ++y) {
        for (int vertex = 0; vertex < grids.size_x * grids.size_z; ++vertex) {
          for (int channel = 0; channel < 3; ++channel) {
            for (int column = 0; column < kColumns; ++column) {
              const auto pixel = static_cast<std::size_t>(top + y) * static_cast<std::size_t>(width) +
                                 static_cast<std::size_t>(left + vertex * kColumns + column);
              visit(value++, 3 * pixel + static_cast<std::size_t>(channel));
            }
          }
        }
      }
    }
  }

  const ColorGrids& grids;
  std::size_t across;
  int width;
  int height;
};

void need_finite(const std::vector<float>& values, const fs::path& file) {
  for (const float value : values) {
    if (!std::isfinite(value)) {
      throw_input_error(file.string(), "value", fmt::format("{}", value), "finite numbers");
    }
  }
}

Image read_sized(const fs::path& file, int width, int height) {
  Image image = read_image(file, width, height, "scene.json");
  need_finite(image.data, file);
  return image;
}

}  // namespace

bool is_appearance_file(const std::string& name) { return name == kEnvironmentName || name == kGridsName; }

void add_appearance(Json& root, const Scene& scene) {
  if (!scene.environment.empty()) {
    root["environment"] = {{"width_px", scene.environment.width}, {"height_px", scene.environment.height}};
  }
  const ColorGrids& grids = scene.color_grids;
  if (grids.empty()) return;
  Json frames = Json::array();
  for (const ColorGrids::Frame& frame : grids.frames) {
    frames.push_back({{"camera", frame.camera}, {"time_s", frame.time_s}});
  }
  root["color_grids"] = {{"size", {grids.size_x, grids.size_y, grids.size_z}}, {"frames", std::move(frames)}};
}

void read_appearance(JsonObject& root, Scene& scene) {
  if (root.has("environment")) {
    root.object("environment", [&](JsonObject& object) {
      scene.environment.width = static_cast<int>(object.integer("width_px", 2, kMostTexels));
      scene.environment.height = static_cast<int>(object.integer("height_px", 2, kMostTexels));
    });
  }
  if (!root.has("color_grids")) return;
  root.object("color_grids", [&](JsonObject& object) {
    ColorGrids& grids = scene.color_grids;
    const Eigen::Vector3d size = object.vector<3>("size");
    const bool allowed = size == size.array().round().matrix() && size.minCoeff() >= 2.0 &&
                         size.maxCoeff() <= static_cast<double>(kMostVertices);
    if (!allowed) {
      throw_input_error(object.file(),
                        object.field("size"),
                        fmt::format("{} x {} x {}", size.x(), size.y(), size.z()),
                        fmt::format("integers from 2 to {}", kMostVertices));
    }
    grids.size_x = static_cast<int>(size.x());
    grids.size_y = static_cast<int>(size.y());
    grids.size_z = static_cast<int>(size.z());
    grids.frames = object.objects("frames", [](JsonObject& frame) {
      return ColorGrids::Frame{frame.text("camera"), frame.number("time_s")};
    });
    if (grids.frames.empty()) {
      throw_input_error(object.file(), object.field("frames"), "none", "at least one");
    }
  });
}

void write_appearance(const fs::path& folder, const Scene& scene) {
  if (!scene.environment.empty()) {
    const fs::path environment_file = folder / kEnvironmentName;
    need_finite(scene.environment.texels, environment_file);
    Image image(scene.environment.width, scene.environment.height, 3);
    image.data = scene.environment.texels;
    write_image(environment_file, image);
  }
  if (scene.color_grids.empty()) return;
  const fs::path grids_file = folder / kGridsName;
  need_finite(scene.color_grids.values, grids_file);
  const GridPicture layout(scene.color_grids);
  Image image(layout.width, layout.height, 3);
  layout.each([&](std::size_t value, std::size_t at) { image.data[at] = scene.color_grids.values[value]; });
  write_image(grids_file, image);
}

void read_appearance_files(const fs::path& folder, Scene& scene) {
  EnvironmentMap& environment = scene.environment;
  if (environment.width > 0) {
    environment.texels =
        read_sized(
            inside(folder, kEnvironmentName, folder.string(), "file"), environment.width, environment.height)
            .data;
  }
  ColorGrids& grids = scene.color_grids;
  if (grids.empty()) return;
  const GridPicture layout(grids);
  const Image image =
      read_sized(inside(folder, kGridsName, folder.string(), "file"), layout.width, layout.height);
  grids.values.resize(grids.frames.size() * grids.values_per_frame());
  layout.each([&](std::size_t value, std::size_t at) { grids.values[value] = image.data[at]; });
}

}  // namespace simuli
