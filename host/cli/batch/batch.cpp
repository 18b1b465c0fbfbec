#include <cstdlib>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/kept.hpp"
#include "host/cli/base/program.hpp"
#include "host/cli/base/progress.hpp"
#include "host/cli/batch/jobs.hpp"
#include "host/cli/batch/runner.hpp"
#include "host/cli/batch/shard.hpp"
#include "host/cli/batch/sweep.hpp"
#include "io/base/file.hpp"
#include "io/base/regular_file.hpp"

namespace simuli::cli {
namespace {

struct BatchCommand {
  std::string jobs;
  std::string shard;  // "K/N"; empty: as the launcher says
  std::vector<std::string> variations;
  std::vector<std::string> words;  // of the command that is varied
  bool overwrite = false;
  bool only_lists = false;
};

/// What is printed meanwhile, instead of the process's stdout.
class Captured {
 public:
  Captured() : old_(std::cout.rdbuf(text_.rdbuf())) {}
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  ~Captured() { std::cout.rdbuf(old_); }
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::streambuf* old_;
};

/// The program once more, for the words of a job.
class ProgramInside {
 public:
  ProgramInside(AddCommands add, const Globals& globals) : add_(std::move(add)), commit_(globals.commit) {}

  [[nodiscard]] std::string name() const {
    return fmt::format("simuli {}{}", version(), commit_.empty() ? "" : fmt::format(" ({})", commit_));
  }
  [[nodiscard]] Work work(const std::vector<std::string>& words) {
    const std::vector<const char*> arguments = arguments_of(words);
    return Line(*this).line.work(static_cast<int>(arguments.size()), arguments.data());
  }
  [[nodiscard]] std::string run(const std::vector<std::string>& words) {
    const std::vector<const char*> arguments = arguments_of(words);
    const Captured captured;
    try {
      Line(*this).line.parse(static_cast<int>(arguments.size()), arguments.data());
    } catch (...) {
      kept_.drop();
      throw;
    }
    return captured.text();
  }

 private:
  struct Line {
    Globals globals;
    CommandLine line;
    explicit Line(ProgramInside& of) : line("simuli", "", [&of] { return of.name(); }) {
      globals.commit = of.commit_;
      globals.kept = &of.kept_;
      add_globals(line.root(), globals);
      of.add_(line, globals);
    }
  };

  AddCommands add_;
  std::string commit_;
  Kept kept_;
};

/// Words that every job begins with: what was said of all.
std::vector<std::string> first_words(const Globals& globals) {
  std::vector<std::string> words;
  if (!globals.device.empty()) words.insert(words.end(), {"--device", globals.device});
  if (globals.quality != Globals().quality) {
    words.insert(words.end(), {"--quality", quality_names()[static_cast<std::size_t>(globals.quality)]});
  }
  return words;
}

const char* name_of(JobState state) {
  switch (state) {
    case JobState::kDue:
      return "due";
    case JobState::kWasDone:
      return "done";
    case JobState::kMade:
      return "made";
    case JobState::kFailed:
      break;
  }
  return "failed";
}

/// One line, written at once: other ranks write to the same place.
void tell_outcome(const std::vector<Job>& jobs, std::size_t i, const JobOutcome& outcome, bool json) {
  const Job& job = jobs[i];
  std::string line;
  if (json) {
    nlohmann::ordered_json out = {{"job", job.name},
                                  {"number", i + 1},
                                  {"of", jobs.size()},
                                  {"state", name_of(outcome.state)},
                                  {"exit_code", outcome.exit_code},
                                  {"seconds", outcome.seconds},
                                  {"outputs", job.work.makes}};
    if (!outcome.error.empty()) out["error"] = outcome.error;
    line = out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  } else {
    line = fmt::format("{} {}/{} {}", name_of(outcome.state), i + 1, jobs.size(), job.name);
    if (outcome.state == JobState::kMade) line += fmt::format(": {:.2f} s", outcome.seconds);
    if (!outcome.error.empty()) line += fmt::format(": {} (exit code {})", outcome.error, outcome.exit_code);
  }
  std::cout << line + '\n' << std::flush;
}

void write_sweep(const BatchCommand& command, ProgramInside& program) {
  if (command.words.empty()) {
    throw Error(ErrorKind::kUsage,
                "--vary: found no command, allowed one behind \"--\": -- render SCENE ...");
  }
  std::vector<Variation> variations;
  for (const std::string& text : command.variations) variations.push_back(parse_variation(text));
  const std::vector<SweepJob> jobs = sweep(variations, command.words);
  static_cast<void>(
      with_context("varying " + jobs.front().name, [&] { return program.work(jobs.front().words); }));
  if (!command.overwrite && is_there(command.jobs)) {
    throw_input_error(
        command.jobs, "file", "something of that name", "a path that does not exist yet, or --overwrite");
  }
  write_file_atomically(command.jobs, jobs_text(jobs));
  std::cout << fmt::format("{} jobs in {}\n", jobs.size(), command.jobs);
}

void run_jobs(const BatchCommand& command, const Globals& globals, ProgramInside& program) {
  const Shard shard = command.shard.empty() ? shard_in([](const char* name) { return std::getenv(name); })
                                            : parse_shard(command.shard);
  const std::vector<Job> jobs =
      read_jobs(command.jobs, first_words(globals), [&](const auto& words) { return program.work(words); });
  const std::vector<std::size_t> own = jobs_of(jobs, shard);
  const std::string part = shard.count == 1 ? "" : fmt::format(" {}/{}", shard.index, shard.count);
  const ProgressStyle style = command.only_lists ? ProgressStyle::kQuiet : progress_style(globals);
  Progress progress("batch" + part, own.size(), style);
  std::size_t ended = 0, failed = 0;
  const auto tell = [&](std::size_t i, const JobOutcome& outcome) {
    tell_outcome(jobs, i, outcome, globals.json);
    ++ended;
    if (outcome.state == JobState::kFailed) ++failed;
    // The time left is told by jobs that took some.
    if (outcome.state == JobState::kWasDone) return progress.start_at(ended);
    progress.update(ended, jobs[i].name.c_str());
  };
  Runner runner(
      jobs,
      {.program = program.name(), .overwrite = command.overwrite, .only_looks = command.only_lists},
      [&](const std::vector<std::string>& words) { return program.run(words); },
      tell);
  runner.run(own);
  progress.finish();
  if (runner.worst() == 0) return;
  throw Ended(runner.worst(), fmt::format("batch{}: {} of {} jobs failed", part, failed, own.size()));
}

void batch(const BatchCommand& command, const Globals& globals, const AddCommands& add) {
  if (globals.kept != nullptr) {
    throw Error(ErrorKind::kUsage, "batch: found as a job of a batch, allowed on its own");
  }
  ProgramInside program(add, globals);
  if (!command.variations.empty()) return write_sweep(command, program);
  if (!command.words.empty()) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("batch: found \"{}\" behind the jobs, allowed with --vary", command.words.front()));
  }
  run_jobs(command, globals, program);
}

}  // namespace

void add_batch(Command app, const Globals& globals, AddCommands add) {
  const auto command = std::make_shared<BatchCommand>();
  Command sub = app.command(
      "batch",
      "many commands, alone or as a rank of mpirun or a task of a Slurm array; what is done is skipped");
  sub.option("JOBS", command->jobs, "JSON file of the jobs").required();
  sub.option(
      "--shard", command->shard, "K/N: each N-th job from K = 0 to N - 1 on; default: as the launcher says");
  sub.option(
         "--vary",
         command->variations,
         "KEY=A,B,C or KEY=FIRST:LAST:STEP: write JOBS instead, the command behind \"--\" with each value; "
         "again for more, each with each. KEY: car.move.left, car.turn, lane_shift, set.KEY, ...")
      .one_at_a_time();
  sub.option("COMMAND", command->words, "with --vary, behind \"--\": what is varied; {} is the job's name");
  sub.flag("--list", command->only_lists, "tell which jobs are done and which are due; run none");
  sub.flag("--overwrite", command->overwrite, "replace what has a job's name and was made by none");
  sub.run([command, &globals, add = std::move(add)] { batch(*command, globals, add); });
}

}  // namespace simuli::cli
