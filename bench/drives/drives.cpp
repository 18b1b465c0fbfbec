#include "bench/drives/drives.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
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

/// `over` before `under`: what both name is as `over` has it.
std::vector<std::string> joined(std::vector<std::string> over, const std::vector<std::string>& under) {
  const std::vector<std::string> first = over;
  for (const std::string& setting : under) {
    const auto is_same = [&](const std::string& other) { return key_of(other) == key_of(setting); };
    if (std::none_of(first.begin(), first.end(), is_same)) over.push_back(setting);
  }
  return over;
}

/// The lines that `options` have and `simuli train` without options has not.
std::vector<std::string> own_lines(const TrainingOptions& options) {
  const std::vector<std::string> plain = lines_of(training_options("", {})), own = lines_of(options);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] != plain[i]) out.push_back(own[i]);
  }
  return out;
}

/// The program that measures: rows of another build are made again.
std::string program_stamp() {
  const fs::path program = "/proc/self/exe";  // is found, too, when a newer one has taken its place
  return fmt::format("simuli {} {} {}",
                     version(),
                     fs::file_size(program),
                     fs::last_write_time(program).time_since_epoch().count());
}

/// Whether the log has boxes of things that move.
bool has_boxes(const Log& log, const TrainingOptions& options) {
  return !moving_actors(log.actors, options.init.actor_min_travel_m).empty();
}

/// One training of a drive.
struct Case {
  const Drive* drive;
  bool labels;                          // the log's own boxes are trained with
  std::vector<TrainingOptions> stages;  // the same training, ever longer; one row each
};

std::vector<Case> cases_of(const std::vector<Drive>& drives, const DrivesOptions& asked) {
  std::vector<Case> cases;
  const std::vector<std::string> lengths =
      asked.lengths.empty() ? std::vector<std::string>{""} : asked.lengths;
  for (const Drive& drive : drives) {
    Case c{&drive, false, {}};
    for (const std::string& length : lengths) {
      std::vector<std::string> settings = asked.settings;
      if (!length.empty()) settings.push_back("iterations=" + length);
      c.stages.push_back(training_options("", joined(settings, drive.settings)));
      const TrainOptions& now = c.stages.back().train;
      if (c.stages.size() > 1 && now.iterations <= c.stages[c.stages.size() - 2].train.iterations) {
        throw Error(ErrorKind::kUsage,
                    fmt::format("--lengths: found {}, allowed more than before it", length));
      }
    }
    if (has_boxes(drive.log, c.stages.front())) {
      c.labels = true;
      cases.push_back(c);
      c.labels = false;
    }
    cases.push_back(std::move(c));
  }
  return cases;
}

/// Says how far all trainings together are.
class Teller {
 public:
  Teller(const std::vector<Case>& cases, const Note& note) : note_(note) {
    for (const Case& c : cases) left_ += c.stages.back().train.iterations;
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
      // It compiles what is not in a cache: its time tells nothing of the others'.
      constexpr double kWorthTelling_s = 5.0;
      if (watch_.seconds() > kWorthTelling_s) {
        note_(fmt::format("{}: kernels compiled in {:.0f} s", title_, watch_.seconds()));
      }
      first_ = status.iteration;
      watch_ = told_ = Stopwatch();
      return;
    }
    if (told_.seconds() < kTellEvery_s) return;
    told_ = Stopwatch();
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
  Stopwatch watch_, told_;
  static constexpr int kUnknown = -1;
  int first_ = kUnknown;  // iteration from which on the time counts
  double left_ = 0.0;     // iterations
};

/// Where the training of a row is kept.
class Keeper {
 public:
  Keeper(fs::path place, const std::string& identity) : place_(std::move(place)), identity_(identity) {
    const fs::path told = place_ / "identity.txt";
    if (fs::exists(told) && read_file(told) == identity) return;
    fs::remove_all(place_);  // of another program, log or settings
    fs::create_directories(place_);
    write_file_atomically(told, identity);
  }
  [[nodiscard]] std::optional<DriveRow> row() const { return kept_row(place_ / "row.json", identity_); }
  [[nodiscard]] fs::path checkpoint() const { return place_ / "checkpoint"; }
  /// The training as it stands, with the seconds that it has taken.
  void save(Training& training, double seconds) const {
    training.save(checkpoint());
    write_file_atomically(place_ / "seconds.txt", fmt::format("{}", seconds));
  }
  [[nodiscard]] double seconds() const {
    return fs::exists(place_ / "seconds.txt") ? std::stod(read_file(place_ / "seconds.txt")) : 0.0;
  }
  void keep(const DriveRow& row, const SceneFile& scene) const {
    write_scene(place_ / "scene", scene);
    keep_row(place_ / "row.json", row, identity_);
  }

 private:
  fs::path place_;
  std::string identity_;
};

/// Trains and compares, case by case.
class Drives {
 public:
  Drives(
      const Device& device, const DrivesOptions& options, fs::path folder, Teller& teller, const Note& note)
      : device_(device), options_(options), folder_(std::move(folder)), teller_(teller), note_(note) {}

  void run(const Case& c) {
    std::optional<Keeper> before;
    for (const TrainingOptions& options : c.stages) {
      DriveRow row{c.drive->name, c.labels, held_out_text(options.frames), own_lines(options), {}};
      const Keeper keeper(place_of(row, options), identity_of(c, options, before));
      if (std::optional<DriveRow> kept = keeper.row()) {
        teller_.skip(options.train.iterations - (before ? done_ : 0));
        row = std::move(*kept);
      } else {
        row = measure(c, options, std::move(row), keeper, before);
      }
      note_(to_line(row));
      rows_.push_back(std::move(row));
      // Only what goes on from there needs it.
      if (before) fs::remove(before->checkpoint());
      done_ = options.train.iterations;
      before.emplace(keeper);
    }
    if (c.stages.size() == 1) fs::remove(before->checkpoint());
  }
  [[nodiscard]] std::vector<DriveRow> rows() && { return std::move(rows_); }

 private:
  [[nodiscard]] fs::path place_of(const DriveRow& row, const TrainingOptions& options) const {
    return folder_ / fmt::format("{}{}_{}", row.drive, row.labels ? "_boxes" : "", options.train.iterations);
  }
  [[nodiscard]] std::string identity_of(const Case& c,
                                        const TrainingOptions& options,
                                        const std::optional<Keeper>& before) const {
    return fmt::format("{}\n{}\n{} {} behind {}\n{}",
                       program_stamp(),
                       device_.info().label(),
                       log_hash(c.drive->log),
                       c.labels,
                       before ? done_ : 0,
                       fmt::join(lines_of(options), "\n"));
  }

  DriveRow measure(const Case& c,
                   const TrainingOptions& options,
                   DriveRow row,
                   const Keeper& keeper,
                   const std::optional<Keeper>& before) {
    Log log = c.drive->log;
    if (!c.labels && has_boxes(log, options)) log.actors.clear();
    Training training(device_, std::move(log), options);
    double spent_s = 0.0;
    if (fs::exists(keeper.checkpoint())) {
      training.resume(keeper.checkpoint());
      spent_s = keeper.seconds();
    } else if (before && fs::exists(before->checkpoint())) {
      training.resume(before->checkpoint());
      spent_s = before->seconds();
    } else {
      training.prepare();
    }
    teller_.begin(row);
    const Stopwatch watch;
    const bool is_kept = !options_.keep.empty();
    training.run([&](const TrainStatus& status) {
      teller_.step(status);
      if (is_kept && status.iteration % kCheckpointEvery == 0)
        keeper.save(training, spent_s + watch.seconds());
    });
    spent_s += watch.seconds();
    if (c.stages.size() > 1) keeper.save(training, spent_s);
    const SceneFile scene = training.result();
    // The log with its boxes, which tell what is inside them whoever trained.
    const EvalReport report = compare(device_, c.drive->log, scene, {});
    row.values = values_of(report, training.report(), spent_s);
    if (is_kept) keeper.keep(row, scene);
    return row;
  }

  Device device_;
  const DrivesOptions& options_;
  fs::path folder_;
  Teller& teller_;
  const Note& note_;
  std::vector<DriveRow> rows_;
  int done_ = 0;  // iterations of the stage before
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
    // Drives of one name are no obstacle to each other's import.
    const fs::path folder = scratch.path() / std::to_string(drives.size());
    fs::create_directory(folder);
    drives.push_back(open_drive(text, folder));
  }
  const std::vector<Case> cases = cases_of(drives, options);
  Teller teller(cases, note);
  Drives all(device, options, options.keep.empty() ? scratch.path() / "rows" : options.keep, teller, note);
  for (const Case& c : cases) all.run(c);
  return std::move(all).rows();
}

}  // namespace simuli::bench
