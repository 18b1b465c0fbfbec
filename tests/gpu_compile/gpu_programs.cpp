#include "tests/gpu_compile/gpu_programs.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "host/device/render/frame/stages.hpp"
#include "host/device/runtime/source.hpp"

namespace simuli::test {
namespace {

constexpr LaneShape kShape{1, 1, 256};
constexpr int kNeighbours = 50;  // as trainings anchor

struct NamedVariant {
  std::string name;
  Variant variant;
};

NamedVariant base(SensorType sensor, int motion) {
  NamedVariant out{sensor == SensorType::kCamera ? "camera" : "lidar", {}};
  out.name += motion == 0 ? " at rest" : motion == 1 ? " moving" : " actors";
  FrameKind& frame = out.variant.frame;
  frame.sensor = sensor;
  frame.moving = frame.origins = motion > 0;
  frame.actors = frame.actor_motion = motion == 2;
  frame.sh_degree = 3;
  frame.median = sensor == SensorType::kLidar;
  frame.culling = sensor == SensorType::kLidar;
  out.variant.options.shape = kShape;
  return out;
}

/// Each with one thing changed. Not all fit each other (lenses and LiDARs): those are left out.
std::vector<NamedVariant> changed(const NamedVariant& from) {
  std::vector<NamedVariant> out;
  const auto add = [&](const std::string& name, const std::function<void(Variant&)>& change) {
    out.push_back({from.name + ", " + name, from.variant});
    change(out.back().variant);
  };
  const bool is_camera = from.variant.frame.sensor == SensorType::kCamera;
  for (int degree = 0; degree < 3; ++degree)
    add("sh " + std::to_string(degree), [=](Variant& v) { v.frame.sh_degree = degree; });
  add("half", [](Variant& v) { v.frame.sh_storage = ShStorage::kHalf; });
  add("median", [](Variant& v) { v.frame.median = !v.frame.median; });
  add("boxes", [](Variant& v) { v.options.extent = Extent::kUnscented; });
  add("boxes, linearized", [](Variant& v) {
    v.options.extent = Extent::kUnscented;
    v.options.projection = Projection::kLinearized;
  });
  add("monte carlo", [](Variant& v) { v.options.projection = Projection::kMonteCarlo; });
  add("draft", [](Variant& v) { v.options.shutter_iterations = 1; });
  for (int degree = 0; degree < 4; ++degree) {
    add(degree == 3 ? "window" : "window, sh " + std::to_string(degree), [=](Variant& v) {
      v.options.order = Order::kWindow;
      v.frame.sh_degree = degree;
    });
  }
  add("window 16", [](Variant& v) {
    v.options.order = Order::kWindow;
    v.options.window = 16;
  });
  for (int degree = 0; degree < 4; ++degree) {
    add(degree == 3 ? "per ray" : "per ray, sh " + std::to_string(degree), [=](Variant& v) {
      v.options.order = Order::kPerRay;
      v.frame.sh_degree = degree;
    });
  }
  add("sh by ray", [](Variant& v) { v.options.sh_direction = ShDirection::kRay; });
  add("detail", [](Variant& v) { v.options.detail = 0.5; });
  add("compensated", [](Variant& v) { v.options.camera_compensation = v.options.lidar_compensation = true; });
  if (!from.variant.frame.moving) add("origins", [](Variant& v) { v.frame.origins = true; });
  if (!from.variant.frame.actors) add("actors at rest", [](Variant& v) { v.frame.actors = true; });
  if (from.variant.frame.actors) {
    add("not rigid", [](Variant& v) { v.frame.deform = true; });
    for (const Order order : {Order::kRange, Order::kWindow, Order::kPerRay}) {
      const char* name = order == Order::kRange ? "" : order == Order::kWindow ? ", window" : ", per ray";
      add(std::string("actors' numbers") + name, [=](Variant& v) {
        v.frame.actor_ids = v.frame.median = true;
        v.options.order = order;
      });
    }
  }
  if (is_camera) {
    for (const LensKind lens : {LensKind::kOpencvPinhole,
                                LensKind::kOpencvFisheye,
                                LensKind::kFtheta,
                                LensKind::kFthetaInverse,
                                LensKind::kMei,
                                LensKind::kEquirectangular,
                                LensKind::kDoubleSphere,
                                LensKind::kEucm})
      add("lens " + std::to_string(static_cast<int>(lens)), [=](Variant& v) { v.frame.lens = lens; });
    for (const int windshield : {1, 2})
      add("windshield " + std::to_string(windshield), [=](Variant& v) {
        v.frame.lens = LensKind::kOpencvPinhole;
        v.frame.windshield = windshield;
      });
  } else {
    add("no culling", [](Variant& v) { v.frame.culling = false; });
  }
  return out;
}

class List {
 public:
  void add(const std::string& name, const std::string& path, const BuildOptions& options) {
    const BuildOptions named = options.named_in(expand_file(path));
    if (there_.insert(path + " " + named.text()).second) programs_.push_back({name, path, named});
  }
  void add_frame(const NamedVariant& frame) {
    const Variant& variant = frame.variant;
    const BuildOptions options = variant.build_options();
    add(frame.name, ProjectStage::file(variant.options.extent), options);
    add(frame.name, "kernels/rays.cl", options);
    const bool in_order = variant.options.order == Order::kRange;
    add(frame.name, in_order ? "kernels/render.cl" : "kernels/render_window.cl", options);
    if (variant.options.order == Order::kPerRay) add(frame.name, "kernels/render_per_ray.cl", options);
    // Those that have a backward pass.
    if (variant.options.sh_direction == ShDirection::kRay || variant.frame.sh_storage == ShStorage::kHalf ||
        variant.options.detail > 0.0)
      return;
    for (const char* path : {"kernels/project_bwd.cl", "kernels/largest_weight.cl"})
      add(frame.name, path, options);
    if (variant.frame.sensor == SensorType::kCamera) add(frame.name, "kernels/off_trajectory.cl", options);
    if (!in_order) add(frame.name, "kernels/replay_window.cl", options);
    if (variant.options.order == Order::kPerRay) add(frame.name, "kernels/replay_per_ray.cl", options);
    for (const bool errors : {false, true}) {
      BuildOptions backward = options;
      add(frame.name + (errors ? ", errors" : ""),
          "kernels/render_bwd_groups.cl",
          backward.define("ERRORS", errors));
    }
  }
  [[nodiscard]] bool has(const std::string& path) const {
    return std::any_of(
        programs_.begin(), programs_.end(), [&](const GpuProgram& p) { return p.path == path; });
  }
  [[nodiscard]] std::vector<GpuProgram> take() && { return std::move(programs_); }

 private:
  std::vector<GpuProgram> programs_;
  std::set<std::string> there_;
};

}  // namespace

std::vector<GpuProgram> gpu_programs() {
  List list;
  std::vector<GpuProgram> others;  // of files that no frame has
  std::vector<NamedVariant> frames;
  for (const SensorType sensor : {SensorType::kCamera, SensorType::kLidar}) {
    for (int motion = 0; motion < 3; ++motion) frames.push_back(base(sensor, motion));
  }
  for (const NamedVariant& frame : frames) list.add_frame(frame);
  for (const NamedVariant& frame : frames) {
    for (const NamedVariant& other : changed(frame)) list.add_frame(other);
  }
  for (NamedVariant& frame : frames) {
    frame.name += ", double";
    frame.variant.options.precision = Precision::kDouble;
    list.add_frame(frame);
  }
  for (const EmbeddedFile& file : embedded_files()) {
    const std::string path(file.path);
    const bool is_of_cpus = path == "kernels/render_bwd_lanes.cl";
    if (!path.ends_with(".cl") || is_of_cpus || list.has(path)) continue;
    for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
      BuildOptions options;
      options.real(precision)
          .define("SENSOR", SensorType::kLidar)
          .define("V", kShape.lanes)
          .define("LS",
                  path == "kernels/scan.cl"             ? 256
                  : path == "kernels/sort.cl"           ? 128
                  : path == "paper/anchor.cl"           ? 16
                  : path.rfind("kernels/loss_", 0) == 0 ? 32
                                                        : 64)
          .define("RADIX_BITS", 8)
          .define("NEIGHBOURS", kNeighbours)
          .define("GRID_X", 16)
          .define("GRID_Y", 16)
          .define("GRID_Z", 8);
      others.push_back({precision == Precision::kFloat ? "alone" : "alone, double", path, options});
    }
  }
  for (const GpuProgram& other : others) list.add(other.name, other.path, other.options);
  return std::move(list).take();
}

}  // namespace simuli::test
