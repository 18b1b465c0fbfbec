#pragma once
// What stands beside a job's output, "OUTPUT.job": which job made it, of what, by which program.
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "host/cli/batch/jobs.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::cli {

struct Record {
  /// Begun ones say whose all that is beside them will be.
  bool is_done = false;
  Json made_by;                                     // made_by()
  std::map<std::string, std::string> outputs = {};  // fingerprint() of each when it was done
};

[[nodiscard]] std::filesystem::path record_beside(const std::string& output);

/// All that the outputs depend on: the job's words, the program, and the fingerprints of what it reads.
[[nodiscard]] Json made_by(const Job& job, const std::string& program);
/// Nothing where there is none that can be read.
[[nodiscard]] std::optional<Record> read_record(const Job& job);
/// In one step. Error{kInput} where it can't be written.
void write_record(const Job& job, const Record& record);

/// Whether all that the job makes is there as this very job has made it.
[[nodiscard]] bool is_done(const Job& job, const std::optional<Record>& record, const Json& made_by);
/// Error{kInput} for something of an output's name that no job has made, or that was changed since.
void need_own_outputs(const Job& job, const std::optional<Record>& record);
/// Whether what a stopped run of this very job has left is there to go on from.
[[nodiscard]] bool is_to_go_on(const Job& job, const std::optional<Record>& record, const Json& made_by);

}  // namespace simuli::cli
