// The command line and the viewer's requests.
#include "host/apps/cli/base/program.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <numbers>
#include <sstream>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/core/scene/edit.hpp"
#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/sensor_rig.hpp"
#include "tests/fuzz/readers.hpp"
#ifdef SIMULI_FUZZ_VIEWER
#include "host/apps/cli/view/view_session.hpp"
#endif

namespace simuli::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "scene";
constexpr const char* kLog = "log";

/// A camera, a LiDAR, a second's drive and a car.
SceneFile small_scene() {
  SceneFile file;
  Scene& scene = file.scene;
  scene.name = "small";
  scene.camera = GaussianSet(SetKind::kCamera, 0, 3);
  scene.lidar = GaussianSet(SetKind::kLidar, 0, 2);
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    set->rotation().col(0).setOnes();
    set->actor.assign(static_cast<std::size_t>(set->size()), 0);
    set->actor.back() = 1;
  }
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 0.5, 1.0}) {
    KeyPose key;
    key.time_s = time_s;
    car.track.push_back(key);
  }
  scene.actors = {car};
  LogCamera camera;
  camera.model = {"front", 8, 6, 5.0, 5.0, 4.0, 3.0};
  file.cameras.push_back(camera);
  Lidar lidar;
  lidar.name = "top";
  lidar.rows = {{0.1}, {-0.1}};
  lidar.columns = 4;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 0.5;
  lidar.range_max = 80.0;
  lidar.beam_divergence = 0.003;
  file.lidars.push_back({lidar, Pose{}});
  file.world_from_rig = Trajectory({{0.0, Pose{}}, {1.0, Pose{}}});
  return file;
}

void write_small_log(const fs::path& folder, const SceneFile& scene) {
  Log log;
  log.folder = folder;
  log.name = "small";
  log.cameras = scene.cameras;
  log.lidars = scene.lidars;
  log.world_from_rig = scene.world_from_rig;
  log.actors = scene.scene.actors;
  fs::create_directories(folder);
  for (const double time_s : {0.0, 0.5, 1.0}) {
    const std::string number = std::to_string(log.images.size());
    log.images.push_back({"front", number + ".png", time_s, time_s});
    write_image(folder / log.images.back().file, Image(8, 6, 3));
    log.sweeps.push_back({"top", number + ".exr", time_s, time_s + 0.1});
    Sweep sweep{nominal_rays(scene.lidars.front().model), {}, {}};
    sweep.range.assign(sweep.rays.azimuth.size(), 5.0F);
    sweep.intensity.assign(sweep.rays.azimuth.size(), 0.5F);
    write_sweep(folder / log.sweeps.back().file, sweep);
  }
  log.sweeps.pop_back();  // it would end after the drive
  write_log(log);
}

/// Takes everything and keeps nothing.
class Silence : public std::streambuf {
  int overflow(int c) override { return traits_type::not_eof(c); }
};

/// In the folder where a small scene and a small log are, without anybody listening; afterwards where it was,
/// and what has been written is gone.
class Workplace {
 public:
  explicit Workplace(const fs::path& file) : before_(fs::current_path()), kept_(file.filename()) {
    fs::current_path(file.parent_path());
    if (!fs::exists(kLog)) {
      const SceneFile scene = small_scene();
      write_scene(kScene, scene);
      write_small_log(kLog, scene);
    }
    out_ = std::cout.rdbuf(&silence_);
    error_ = std::cerr.rdbuf(&silence_);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  ~Workplace() {
    std::cout.rdbuf(out_);
    std::cerr.rdbuf(error_);
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(".", ignored)) {
      const fs::path name = entry.path().filename();
      if (name != kept_ && name != kScene && name != kLog) fs::remove_all(entry.path(), ignored);
    }
    fs::current_path(before_, ignored);
  }

 private:
  fs::path before_, kept_;
  Silence silence_;
  std::streambuf* out_ = nullptr;
  std::streambuf* error_ = nullptr;
};

/// The commands that the arguments name, or all of them where they name none: making one takes longer than
/// running it.
void add_commands(const std::vector<std::string>& arguments,
                  cli::CommandLine& line,
                  const cli::Globals& globals) {
  using Add = void (*)(cli::Command, const cli::Globals&);
  constexpr std::array<std::pair<std::string_view, Add>, 9> kCommands{{{"actors", cli::add_actors},
                                                                        {"devices", cli::add_devices},
                                                                        {"eval", cli::add_eval},
                                                                        {"export", cli::add_export},
                                                                        {"import", cli::add_import},
                                                                        {"info", cli::add_info},
                                                                        {"render", cli::add_render},
                                                                        {"train", cli::add_train},
                                                                        {"view", cli::add_view}}};
  const auto is_named = [&](const auto& command) {
    return std::find(arguments.begin(), arguments.end(), command.first) != arguments.end();
  };
  const bool any = std::any_of(kCommands.begin(), kCommands.end(), is_named);
  const cli::Command root = line.root();
  root.require_command();
  for (const auto& command : kCommands) {
    if (!any || is_named(command)) command.second(root, globals);
  }
}

/// A line of the file is an argument. Commands run beside a small scene and a small log, on a machine without
/// OpenCL devices: up to the point where they ask for one. Those that take long and need none are left out.
void run_command_line(const fs::path& file) {
  constexpr std::size_t kMost = 64;
  std::vector<std::string> lines{"simuli"};
  std::istringstream in(read_file(file));
  for (std::string text; lines.size() < kMost && std::getline(in, text);) lines.push_back(text);
  // Nothing outside of the folder is read or written.
  if (std::any_of(lines.begin(), lines.end(), [](const std::string& text) {
        return text.find('/') != std::string::npos || text.find("..") != std::string::npos;
      })) {
    return;
  }
  std::vector<const char*> arguments;
  for (const std::string& text : lines) arguments.push_back(text.c_str());
  ::setenv("OCL_ICD_VENDORS", "none", 1);
  const Workplace workplace(file);
  cli::run_arguments(
      "simuli",
      "",
      static_cast<int>(arguments.size()),
      arguments.data(),
      [&](cli::CommandLine& line, const cli::Globals& globals) { add_commands(lines, line, globals); });
}

#ifdef SIMULI_FUZZ_VIEWER
/// The body of a page's request, and what the session looks up of it.
void read_view_request(const fs::path& file) {
  static const SceneFile scene = small_scene();
  static const SensorRig rig = [] {
    SensorRig of_scene(scene);
    of_scene.refuse_files();
    return of_scene;
  }();
  const cli::ViewRequest request = cli::parse_view_request(read_file(file));
  const Sensor sensor = rig.find(request.sensor, Pose{});
  if (sensor.is_camera()) (void)sensor.resized(request.width, request.width);
  (void)edited(scene.scene.actors, request.edits());
}
#endif

constexpr std::array kProgram{
    FuzzedReader{"command_line", Form::kText, run_command_line, "arguments"},
#ifdef SIMULI_FUZZ_VIEWER
    FuzzedReader{"view_request", Form::kJson, read_view_request, "request.json"},
#endif
};

}  // namespace

std::span<const FuzzedReader> fuzzed_program() { return kProgram; }

}  // namespace simuli::test
