#pragma once
// Does jobs, each once however many processes are at it.
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/cli/batch/jobs.hpp"

namespace simuli::cli {

enum class JobState { kDue, kWasDone, kMade, kFailed };

/// How a job ended, or where it stands.
struct JobOutcome {
  JobState state = JobState::kDue;
  int exit_code = 0;
  std::string error = {};  // one line
  double seconds = 0.0;    // that it took this process
};

struct RunnerOptions {
  std::string program;      // whose results are taken for the same
  bool overwrite = false;   // what no job has made, too
  bool only_looks = false;  // nothing is run
};

class Runner {
 public:
  /// Runs a command line and returns what it prints. Whatever leaves it but Interrupted is told of the job.
  using RunWords = std::function<std::string(const std::vector<std::string>& words)>;
  /// Told of each job once, in the order of their ends.
  using Tell = std::function<void(std::size_t job, const JobOutcome& outcome)>;

  Runner(const std::vector<Job>& jobs, RunnerOptions options, RunWords run, Tell tell);

  /// These jobs, first those that are done, the others in their order; one that another process is at comes
  /// last, when that one has ended. A job whose needs have failed fails.
  void run(const std::vector<std::size_t>& own);
  /// The greatest exit code of a job; 0 without failures.
  [[nodiscard]] int worst() const { return worst_; }

 private:
  void end(std::size_t job, JobOutcome outcome);
  /// False while another process is at it; `waits`: until that has ended.
  [[nodiscard]] bool try_job(std::size_t job, bool waits);
  [[nodiscard]] bool needs_failed(std::size_t job);
  [[nodiscard]] bool is_done_already(std::size_t job) const;
  [[nodiscard]] JobOutcome make(const Job& job) const;
  void run_in_place(const Job& job) const;

  const std::vector<Job>& jobs_;
  RunnerOptions options_;
  RunWords run_;
  Tell tell_;
  std::vector<JobOutcome> outcomes_;
  int worst_ = 0;
};

}  // namespace simuli::cli
