#include "optim/train/chunk_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <string>

#include "host/core/base/error.hpp"
#include "optim/init/initialize.hpp"
#include "optim/train/memory.hpp"

namespace simuli {
namespace {

constexpr double kShortest_m = 20.0;  // shortest chunk
constexpr double kLongest_m = 100.0;  // longest of several chunks: pictures look along it, and it takes longer to train
constexpr double kShort_m = 20.0, kLong_m = 60.0;  // lengths of the two sample pieces
constexpr double kMargin = 1.2;  // other parts of the drive may need more than its middle
// Measured host memory (bench/RESULTS.md): the program and its driver, ...
constexpr double kProgramBytes = 300e6;
constexpr double kVoxelBytes = 500.0;  // ... per voxel during initialisation,
constexpr double kParticleCopies = 2.0;  // copies of the particles in addition to the device's,
constexpr double kRayBytes = 24.0;  // per sweep ray during the search for moving objects,
constexpr double kFrameBytes = 2e3;  // per frame in the log and its copies,
constexpr double kKeyBytes = 600.0;  // per key pose of an actor's track in the log,
constexpr double kSceneCopies = 1.5;  // and copies of the finished scene: itself and its reordered copy.
constexpr double kDeviceScene = 1.5;  // device memory of a scene as a multiple of its bytes

/// The first option that requires training in one run, its value and the values that would allow chunks; null
/// if there is none.
struct Uncut {
  const char* key = nullptr;
  const char* found = nullptr;
  const char* allowed = nullptr;
};
Uncut uncut_by(const TrainingOptions& o) {
  if (o.train.length.automatic) return {"auto.on", "true", "a number of iterations"};
  if (o.train.appearance.color_grids == ColorGridsOf::kPictures) return {"color_grids", "pictures", "auto, none"};
  return {};
}

/// Amounts of data in a piece of the drive.
struct Content {
  double voxels = 0.0, camera = 0.0, lidar = 0.0;
};
Content operator+(const Content& a, const Content& b) {
  return {a.voxels + b.voxels, a.camera + b.camera, a.lidar + b.lidar};
}
Content operator*(double times, const Content& a) {
  return {times * a.voxels, times * a.camera, times * a.lidar};
}

struct Need {
  double host = 0.0, device = 0.0, largest_buffer = 0.0;
};

class Planner {
 public:
  Planner(const Device& device, const Log& log, const TrainingOptions& options, const DrivenPath& path)
      : device_(device), log_(log), options_(options), path_(path) {
    own_.frames = nothing_held_out(options.frames);
    own_.init = options.init;
    own_.train = options.train;
    // Dropping moving points is too slow for an estimate, unless no sweep would remain.
    own_.init.drop_moving = false;
    own_.init.sweep_depth = options.init.sweep_depth && log.sweeps.empty();
    for (const Actor& actor : log.actors) keys_ += static_cast<double>(actor.track.size());
    frames_ =
        static_cast<double>(std::min<std::uint64_t>(frame_budget(options), frame_bytes(log, options.frames)));
    short_m_ = std::min(kShort_m, path.length_m() / 3.0);
    long_m_ = std::min(kLong_m, path.length_m());
    const Content few = content_of(short_m_);
    long_ = content_of(long_m_);
    if (long_m_ > short_m_) {
      const auto slope = [this](double less, double more) {
        return std::max(more - less, 0.0) / (long_m_ - short_m_);
      };
      per_m_ = {
          slope(few.voxels, long_.voxels), slope(few.camera, long_.camera), slope(few.lidar, long_.lidar)};
    }
  }

  /// Returns the memory of a chunk from the drive's middle, or of the finished scene if that is larger.
  [[nodiscard]] Need need(double length_m) const {
    const Content middle = long_ + (length_m - long_m_) * per_m_, content = kMargin * middle;
    const Log log = piece(length_m);
    Need need = device_need(log, content, length_m);
    double rays = 0.0;
    for (const SweepFrame& frame : log.sweeps) {
      rays += static_cast<double>(ray_count(log_.lidar(frame.lidar).model));
    }
    const bool shares = device_.info().is_cpu;  // device memory is host memory
    const double always = kProgramBytes + kKeyBytes * keys_ +
                          kFrameBytes * static_cast<double>(log_.images.size() + log_.sweeps.size()) +
                          frames_;
    Content all = long_ + (path_.length_m() - long_m_) * per_m_;
    // Each chunk has a camera set of its own, which extends beyond it.
    all.camera = std::max(all.camera, path_.length_m() / length_m * middle.camera);
    const double scene = scene_bytes(all) * (kSceneCopies + (shares ? kDeviceScene : 0.0));
    const double chunk = kVoxelBytes * content.voxels + kParticleCopies * scene_bytes(content) +
                           kRayBytes * rays + (shares ? need.device : 0.0);
    need.host = always + std::max(scene, chunk);
    return need;
  }

 private:
  [[nodiscard]] Log piece(double length_m) const {
    const double from_m = 0.5 * (path_.length_m() - length_m);
    return log_of(log_, options_.frames, path_, {from_m, from_m + length_m}, options_.chunks);
  }
  [[nodiscard]] Content content_of(double length_m) {
    const SceneInit init = initialize_scene(piece(length_m), own_.frames, own_.init);
    environment_ = init.scene.environment;
    actors_ = init.scene.actors.size();
    camera_degree_ = init.scene.camera.sh_degree;
    lidar_degree_ = init.scene.lidar.sh_degree;
    return {static_cast<double>(init.report.voxels + init.report.actor_points),
            static_cast<double>(init.scene.camera.size()),
            static_cast<double>(init.scene.lidar.size())};
  }
  [[nodiscard]] double scene_bytes(const Content& c) const {
    return sizeof(float) * (c.camera * param_rows(camera_degree_) + c.lidar * param_rows(lidar_degree_));
  }
  [[nodiscard]] Need device_need(const Log& log, const Content& content, double length_m) const {
    const auto sized = [](SetKind kind, int degree, double count) {
      GaussianSet set(kind, degree, 0);
      set.params.resize(static_cast<Eigen::Index>(count), 0);  // the count matters; no parameters are stored
      return set;
    };
    Scene scene;
    scene.camera = sized(SetKind::kCamera, camera_degree_, content.camera);
    scene.lidar = sized(SetKind::kLidar, lidar_degree_, content.lidar);
    scene.environment = environment_;
    scene.actors.resize(actors_);
    TrainingOptions own = own_;
    const double share = length_m / std::max(path_.length_m(), length_m);
    own.train.iterations = static_cast<int>(std::ceil(share * options_.train.iterations));
    if (length_m < path_.length_m())
      own.train.appearance.color_grids = ColorGridsOf::kNone;  // as chunked_run.cpp does
    const MemoryNeed need = training_memory(device_, log, scene, own);
    return {0.0, static_cast<double>(need.total), static_cast<double>(need.largest_buffer)};
  }

  const Device& device_;
  const Log& log_;
  const TrainingOptions& options_;
  const DrivenPath& path_;
  TrainingOptions own_;
  EnvironmentMap environment_;
  std::size_t actors_ = 0;
  int camera_degree_ = 0, lidar_degree_ = 0;
  double keys_ = 0.0;
  double frames_ = 0.0;  // bytes of cached frames
  double short_m_ = 0.0, long_m_ = 0.0;
  Content long_, per_m_;
};

[[noreturn]] void refuse(ErrorKind kind,
                         const char* what,
                         double found,
                         double allowed,
                         const std::string& by,
                         double length_m,
                         const Uncut& uncut) {
  const std::string why = uncut.key != nullptr ? fmt::format(", which {} keeps in one piece", uncut.key) : "";
  throw Error(
      kind,
      fmt::format("train: {} memory: found a need of {:.3f} GB for {:.0f} m of the drive at a time{}; "
                  "allowed {:.3f} GB by {} (fewer particles: init.voxel_m, init.max_camera, "
                  "init.max_lidar; smaller pictures: --scale; fewer frames kept: cache_bytes)",
                  what,
                  found * 1e-9,
                  length_m,
                  why,
                  allowed * 1e-9,
                  by));
}

}  // namespace

bool plans_chunks(const TrainingOptions& options) {
  return options.chunks.length_m == 0.0 &&
         (options.chunks.host_memory_bytes > 0 || options.train.memory_bytes > 0);
}

void need_uncut(const TrainingOptions& o) {
  const Uncut uncut = uncut_by(o);
  if (o.chunks.length_m == 0.0 || uncut.key == nullptr) return;
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: found {}, allowed {} where chunk.length_m cuts the drive",
                          uncut.key,
                          uncut.found,
                          uncut.allowed));
}

ChunkPlan plan_chunks(const Device& device,
                           const Log& log,
                           const TrainingOptions& options,
                           const DrivenPath& path) {
  const DeviceInfo& info = device.info();
  const std::size_t given = options.train.memory_bytes, host = options.chunks.host_memory_bytes;
  const auto device_limit = static_cast<double>(given > 0 ? given : info.global_bytes);
  const Planner planner(device, log, options, path);
  const Uncut uncut = uncut_by(options);
  const double most = uncut.key != nullptr ? 1.0 : std::max(1.0, std::floor(path.length_m() / kShortest_m));
  const double fewest = std::min(most, std::ceil(path.length_m() / kLongest_m));  // of several chunks
  for (double count = 1.0;; count = std::max(count + 1.0, fewest)) {
    const double length_m = path.length_m() / count;
    const Need need = planner.need(length_m);
    const bool fits_host = host == 0 || need.host <= static_cast<double>(host);
    const bool fits_device =
        need.device <= device_limit && need.largest_buffer <= static_cast<double>(info.max_alloc_bytes);
    if (fits_host && fits_device) {
      return {static_cast<std::size_t>(count),
              length_m,
              static_cast<std::uint64_t>(need.host),
              static_cast<std::uint64_t>(need.device)};
    }
    if (count < most) continue;
    if (!fits_device) {
      refuse(ErrorKind::kDevice,
             "device",
             need.device,
             device_limit,
             given > 0 ? "memory_bytes" : info.label(),
             length_m,
             uncut);
    }
    refuse(ErrorKind::kUsage,
           "host",
           need.host,
           static_cast<double>(host),
           "host_memory_bytes",
           length_m,
           uncut);
  }
}

}  // namespace simuli
