#pragma once
// JOBS.json: {"format": "simuli batch", "version": 1, "jobs": [{"name": "a", "run": ["render", ...]}, ...]}.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/cli/base/command.hpp"
#include "host/cli/batch/shard.hpp"

namespace simuli::cli {

/// A command line of the program whose results are files.
struct Job {
  std::string name;
  std::vector<std::string> words;  // behind the program's name
  std::string stdout_file;         // what it prints goes there; empty: nowhere
  Work work;                       // with stdout_file, if there is one; makes something
  std::vector<std::size_t> needs;  // jobs before it that make what it reads

  /// Beside it stands what made it (host/cli/batch/record.hpp).
  [[nodiscard]] const std::string& output() const { return work.makes.front(); }
};

/// What a command line would do; Error{kUsage} for words that are not allowed.
using AskWork = std::function<Work(const std::vector<std::string>& words)>;

/// `first` are the first words of every job. Error{kInput} for what is no such file, a job that is not
/// allowed or makes nothing, names or outputs that two have, outputs within another's or within what their
/// job reads, and a job that reads what one behind it makes.
[[nodiscard]] std::vector<Job> read_jobs(const std::filesystem::path& file,
                                         const std::vector<std::string>& first,
                                         const AskWork& ask);

/// Those of a shard, in their order. Jobs that read what others make are in the shard of these; such groups
/// go round the shards in the order of their first jobs.
[[nodiscard]] std::vector<std::size_t> jobs_of(const std::vector<Job>& jobs, const Shard& shard);

}  // namespace simuli::cli
