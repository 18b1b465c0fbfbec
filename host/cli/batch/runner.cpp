#include "host/cli/batch/runner.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>
#include <thread>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/one_line.hpp"
#include "host/base/stopwatch.hpp"
#include "host/cli/base/interrupt.hpp"
#include "host/cli/base/program.hpp"
#include "host/cli/batch/record.hpp"
#include "io/base/file.hpp"
#include "io/base/fingerprint.hpp"
#include "io/base/output.hpp"
#include "io/base/regular_file.hpp"
#include "io/base/temporary.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

/// Gone in one step, however long removing it takes.
void remove_whole(const fs::path& path) {
  if (!is_there(path)) return;
  const Temporary gone(without_trailing_slash(path));
  if (::rename(without_trailing_slash(path).c_str(), gone.path().c_str()) != 0)
    throw_errno(path, "rename", "an output to replace");
}

/// What runs that were killed have left, and what this one replaces.
void clear(const Job& job, bool keeps_unfinished) {
  for (const std::string& path : job.work.makes) {
    remove_stale_temporaries(without_trailing_slash(path));
    remove_whole(path);
  }
  for (const std::string& path : job.work.unfinished) {
    remove_stale_temporaries(path);
    if (!keeps_unfinished) remove_whole(path);
  }
}

}  // namespace

Runner::Runner(const std::vector<Job>& jobs, RunnerOptions options, RunWords run, Tell tell)
    : jobs_(jobs),
      options_(std::move(options)),
      run_(std::move(run)),
      tell_(std::move(tell)),
      outcomes_(jobs.size()) {}

void Runner::end(std::size_t job, JobOutcome outcome) {
  outcomes_[job] = std::move(outcome);
  worst_ = std::max(worst_, outcomes_[job].exit_code);
  tell_(job, outcomes_[job]);
}

bool Runner::needs_failed(std::size_t job) {
  for (const std::size_t need : jobs_[job].needs) {
    if (outcomes_[need].state != JobState::kFailed) continue;
    end(job,
        {.state = JobState::kFailed,
         .exit_code = outcomes_[need].exit_code,
         .error = fmt::format("job \"{}\" has failed, whose output it reads", jobs_[need].name)});
    return true;
  }
  return false;
}

void Runner::run_in_place(const Job& job) const {
  for (const std::string& path : job.work.makes) {
    std::error_code failed;
    fs::create_directories(parent_of(without_trailing_slash(path)), failed);
    if (failed) throw_input_error(path, "folder", failed.message(), "a path that can be written");
  }
  const std::string printed = run_(job.words);
  if (!job.stdout_file.empty()) write_file_atomically(job.stdout_file, printed);
}

JobOutcome Runner::make(const Job& job) const {
  const Stopwatch watch;
  const Json from = made_by(job, options_.program);
  const std::optional<Record> old = read_record(job);
  if (is_done(job, old, from)) return {.state = JobState::kWasDone};
  if (!options_.overwrite) need_own_outputs(job, old);
  const bool goes_on = is_to_go_on(job, old, from);
  Record record{.made_by = from};
  for (const std::string& path : job.work.makes) record.outputs[path] = "";
  remove_stale_temporaries(record_beside(job.output()));
  write_record(job, record);  // from here on the outputs are this job's
  clear(job, goes_on);
  run_in_place(job);
  for (auto& [path, print] : record.outputs) {
    print = fingerprint(path);
    if (print.empty()) throw_input_error(path, "output", "nothing of that name", "what the command makes");
  }
  if (made_by(job, options_.program) != from) {
    throw_input_error(job.output(),
                      "inputs",
                      "some that were changed while it was made",
                      "the same from its start to its end");
  }
  record.is_done = true;
  write_record(job, record);
  return {.state = JobState::kMade, .seconds = watch.seconds()};
}

bool Runner::try_job(std::size_t job, bool waits) {
  constexpr std::chrono::milliseconds kAskAgain{100};
  for (;;) {
    try {
      const OutputLock lock(record_beside(jobs_[job].output()));
      end(job, make(jobs_[job]));
      return true;
    } catch (const OutputTaken&) {
      if (!waits) return false;
      std::this_thread::sleep_for(kAskAgain);
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& thrown) {
      const Failure failure = failure_of(thrown);
      end(job,
          {.state = JobState::kFailed, .exit_code = failure.exit_code, .error = on_one_line(failure.line)});
      return true;
    }
  }
}

bool Runner::is_done_already(std::size_t job) const {
  // What needs others is looked at when these are done.
  const Job& asked = jobs_[job];
  const bool are_needs_done = std::all_of(asked.needs.begin(), asked.needs.end(), [&](std::size_t need) {
    return outcomes_[need].state == JobState::kWasDone;
  });
  return are_needs_done && is_done(asked, read_record(asked), made_by(asked, options_.program));
}

void Runner::run(const std::vector<std::size_t>& own) {
  std::vector<std::size_t> due, taken;
  for (const std::size_t job : own) {
    // Who was killed behind its last step has left a lock, which goes with the one of this process.
    if (is_done_already(job) && !is_there(lock_beside(record_beside(jobs_[job].output())))) {
      end(job, {.state = JobState::kWasDone});
    } else {
      due.push_back(job);
    }
  }
  for (const std::size_t job : due) {
    const Job& asked = jobs_[job];
    const bool waits = std::any_of(asked.needs.begin(), asked.needs.end(), [&](std::size_t need) {
      return outcomes_[need].state == JobState::kDue;
    });
    if (options_.only_looks) {
      end(job, {.state = is_done_already(job) ? JobState::kWasDone : JobState::kDue});
    } else if (!needs_failed(job) && (waits || !try_job(job, false))) {
      taken.push_back(job);
    }
  }
  for (const std::size_t job : taken) {
    if (!needs_failed(job)) static_cast<void>(try_job(job, true));
  }
}

}  // namespace simuli::cli
