#include "bench/drives/drives.hpp"

#include <algorithm>
#include <ctime>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <sstream>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/base/version.hpp"
#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/init/initialize_actors.hpp"

namespace simuli::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kTellEvery_s = 10.0;
constexpr int kCheckpointEvery = 200;

std::string key_of(const std::string& setting) { return setting.substr(0, setting.find('=')); }

/// Merges settings; `over` has priority over `under`.
std::vector<std::string> joined(std::vector<std::string> over, const std::vector<std::string>& under) {
  const std::vector<std::string> first = over;
  for (const std::string& setting : under) {
    const auto is_same = [&](const std::string& other) { return key_of(other) == key_of(setting); };
    if (std::none_of(first.begin(), first.end(), is_same)) over.push_back(setting);
  }
  return over;
}

/// Returns the settings that differ from `simuli train` without options.
std::vector<std::string> own_lines(const TrainingOptions& options) {
  const std::vector<std::string> plain = lines_of(training_options("", {})), own = lines_of(options);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] != plain[i]) out.push_back(own[i]);
  }
  return out;
}

/// Returns an identifier of the program: rows of other builds are computed again.
std::string program_stamp() {
  const fs::path program = "/proc/self/exe";  // also valid after the file has been replaced
  return fmt::format("simuli {} {} {}",
                     version(),
                     fs::file_size(program),
                     fs::last_write_time(program).time_since_epoch().count());
}

/// Whether the log contains boxes of moving objects.
bool has_boxes(const Log& log, const TrainingOptions& options) {
  return !moving_actors(log.actors, options.init.actor_min_travel_m).empty();
}

/// Trainings of a drive.
struct Case {
  const Drive* drive;
  bool labels;                           // trained with the boxes of the log
  std::vector<TrainingOptions> lengths;  // equal except for ascending iterations; one row each
};

/// Returns lengths that double, to find the first that reaches a quality.
std::vector<std::string> doublings() {
  std::vector<std::string> out;
  constexpr int kFirst = 100, kTimes = 6;
  for (int k = 0; k < kTimes; ++k) out.push_back(std::to_string(kFirst << k));
  return out;
}

/// Returns the CPU time of all threads of this process in s.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<Case> cases_of(const std::vector<Drive>& drives, const DrivesOptions& requested) {
  std::vector<Case> cases;
  std::vector<std::string> lengths = requested.lengths;
  if (lengths.empty()) lengths = requested.time_to_db > 0.0 ? doublings() : std::vector<std::string>{""};
  for (const Drive& drive : drives) {
    Case c{&drive, false, {}};
    for (const std::string& length : lengths) {
      std::vector<std::string> settings = requested.settings;
      if (!length.empty()) settings.push_back("iterations=" + length);
      c.lengths.push_back(training_options("", joined(settings, drive.settings)));
      const TrainOptions& now = c.lengths.back().train;
      if (c.lengths.size() > 1 && now.iterations <= c.lengths[c.lengths.size() - 2].train.iterations) {
        throw Error(ErrorKind::kUsage,
                    fmt::format("--lengths: found {}, allowed more than before it", length));
      }
    }
    if (has_boxes(drive.log, c.lengths.front())) {
      c.labels = true;
      cases.push_back(c);
      c.labels = false;
    }
    cases.push_back(std::move(c));
  }
  return cases;
}

/// Reports the progress of all trainings.
class ProgressReport {
 public:
  ProgressReport(const std::vector<Case>& cases, const Note& note) : note_(note) {
    for (const Case& c : cases) {
      for (const TrainingOptions& o : c.lengths) left_ += o.train.iterations;
    }
  }
  void skip(int iterations) { left_ -= iterations; }
  void begin(const DriveRow& row) {
    title_ = row.title();
    watch_ = Stopwatch();
    first_ = kUnknown;
  }
  void step(const TrainStatus& status) {
    left_ -= 1.0;
    if (first_ == kUnknown) {
      // The first iterations compile kernels; their time does not predict the remaining time.
      constexpr double kLeastReported_s = 5.0;
      if (watch_.seconds() > kLeastReported_s) {
        note_(fmt::format("{}: kernels compiled in {:.0f} s", title_, watch_.seconds()));
      }
      first_ = status.iteration;
      watch_ = reported_ = Stopwatch();
      return;
    }
    if (reported_.seconds() < kTellEvery_s) return;
    reported_ = Stopwatch();
    const double pace_s = watch_.seconds() / (status.iteration - first_);
    note_(fmt::format("{}: {} of {} iterations, {:.1f} min left, {:.0f} min of all trainings",
                      title_,
                      status.iteration,
                      status.planned,
                      pace_s * (status.planned - status.iteration) / 60.0,
                      pace_s * std::max(left_, 0.0) / 60.0));
  }

 private:
  const Note& note_;
  std::string title_;
  Stopwatch watch_, reported_;
  static constexpr int kUnknown = -1;
  int first_ = kUnknown;  // first iteration of the time measurement
  double left_ = 0.0;     // iterations
};

/// Time of a training so far.
struct Taken {
  double wall_s = 0.0;       // without initialisation
  double processor_s = 0.0;  // with initialisation
};

/// Folder that stores the training of a row.
class Keeper {
 public:
  Keeper(fs::path place, const std::string& identity) : place_(std::move(place)), identity_(identity) {
    const fs::path identity_file = place_ / "identity.txt";
    if (fs::exists(identity_file) && read_file(identity_file) == identity) return;
    fs::remove_all(place_);  // of another program, log or settings
    fs::create_directories(place_);
    write_file_atomically(identity_file, identity);
  }
  [[nodiscard]] std::optional<DriveRow> row() const { return kept_row(place_ / "row.json", identity_); }
  [[nodiscard]] fs::path checkpoint() const { return place_ / "checkpoint"; }
  /// Saves the training and its times so far.
  void save(Training& training, const Taken& taken) const {
    training.save(checkpoint());
    write_file_atomically(place_ / "seconds.txt", fmt::format("{} {}", taken.wall_s, taken.processor_s));
  }
  [[nodiscard]] Taken taken() const {
    Taken out;
    std::istringstream(read_file(place_ / "seconds.txt")) >> out.wall_s >> out.processor_s;
    return out;
  }
  void keep(const DriveRow& row, const SceneFile& scene) const {
    write_scene(place_ / "scene", scene);
    keep_row(place_ / "row.json", row, identity_);
  }

 private:
  fs::path place_;
  std::string identity_;
};

/// Trains and compares case by case.
class Drives {
 public:
  Drives(const Device& device,
         const DrivesOptions& options,
         fs::path folder,
         ProgressReport& progress,
         const Note& note)
      : device_(device), options_(options), folder_(std::move(folder)), progress_(progress), note_(note) {}

  void run(const Case& c) {
    for (const TrainingOptions& options : c.lengths) {
      DriveRow row{c.drive->name, c.labels, held_out_text(options.frames), own_lines(options), {}};
      const Keeper keeper(place_of(row, options), identity_of(c, options));
      if (std::optional<DriveRow> kept = keeper.row()) {
        progress_.skip(options.train.iterations);
        row = std::move(*kept);
      } else {
        row = measure(c, options, std::move(row), keeper);
      }
      note_(to_line(row));
      rows_.push_back(std::move(row));
      fs::remove(keeper.checkpoint());
      if (is_reached(rows_.back())) return;
    }
  }
  [[nodiscard]] std::vector<DriveRow> rows() && { return std::move(rows_); }

 private:
  [[nodiscard]] fs::path place_of(const DriveRow& row, const TrainingOptions& options) const {
    return folder_ / fmt::format("{}{}_{}", row.drive, row.labels ? "_boxes" : "", options.train.iterations);
  }
  /// Whether the row reaches options_.time_to_db.
  [[nodiscard]] bool is_reached(const DriveRow& row) const {
    const double db = options_.time_to_db;
    if (db <= 0.0 || row.value("psnr_db") < db) return false;
    note_(fmt::format("{}: {} dB with {} iterations, {:.0f} s of processor time",
                      row.title(),
                      db,
                      row.value("iterations"),
                      row.value("processor_s")));
    return true;
  }
  [[nodiscard]] std::string identity_of(const Case& c, const TrainingOptions& options) const {
    return fmt::format("{}\n{}\n{} {}\n{}",
                       program_stamp(),
                       device_.info().label(),
                       log_hash(c.drive->log),
                       c.labels,
                       fmt::join(lines_of(options), "\n"));
  }

  DriveRow measure(const Case& c, const TrainingOptions& options, DriveRow row, const Keeper& keeper) {
    const double begun_s = processor_seconds();
    Log log = c.drive->log;
    if (!c.labels && has_boxes(log, options)) log.actors.clear();
    TrainingOptions timed = options;
    timed.cache_initialization = false;
    Training training(device_, std::move(log), timed);
    Taken before;
    if (fs::exists(keeper.checkpoint())) {
      training.resume(keeper.checkpoint());
      before = keeper.taken();
    } else {
      training.prepare();
    }
    progress_.begin(row);
    const Stopwatch watch;
    const auto taken = [&] {
      return Taken{before.wall_s + watch.seconds(), before.processor_s + processor_seconds() - begun_s};
    };
    const bool is_kept = !options_.keep.empty();
    training.run([&](const TrainStatus& status) {
      progress_.step(status);
      if (is_kept && status.iteration % kCheckpointEvery == 0) keeper.save(training, taken());
    });
    const double train_s = taken().wall_s;
    const SceneFile scene = training.result();
    const double processor_s = taken().processor_s;
    // The log with its boxes, which select the pixels and rays of actors for all trainings.
    const EvalReport report = compare(device_, c.drive->log, scene, {});
    row.values = values_of(report, training.report(), train_s, processor_s);
    if (is_kept) keeper.keep(row, scene);
    return row;
  }

  Device device_;
  const DrivesOptions& options_;
  fs::path folder_;
  ProgressReport& progress_;
  const Note& note_;
  std::vector<DriveRow> rows_;
};

}  // namespace

std::vector<DriveRow> run_drives(const std::string& device_request,
                                 const DrivesOptions& options,
                                 const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  std::vector<Drive> drives;
  for (const std::string& text : options.drives) {
    // Separate folders, because drives may have the same name.
    const fs::path folder = scratch.path() / std::to_string(drives.size());
    fs::create_directory(folder);
    drives.push_back(open_drive(text, folder));
  }
  const std::vector<Case> cases = cases_of(drives, options);
  ProgressReport progress(cases, note);
  Drives all(device, options, options.keep.empty() ? scratch.path() / "rows" : options.keep, progress, note);
  for (const Case& c : cases) all.run(c);
  return std::move(all).rows();
}

}  // namespace simuli::bench
