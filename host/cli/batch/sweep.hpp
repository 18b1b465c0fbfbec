#pragma once
// A sweep over edits as a file of jobs: simuli batch JOBS.json --vary KEY=VALUES ... -- COMMAND...
#include <cstddef>
#include <string>
#include <vector>

namespace simuli::cli {

/// What is varied, and each value as it is written in the command.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// "KEY=A,B,C", or "KEY=FIRST:LAST:STEP" with numbers, the last one included. Error{kUsage} for anything
/// else. A KEY is
///   ACTOR.move.forward|left|up   m, ACTOR.turn   degrees, ACTOR.resize, ACTOR.retime.rate|delay,
///   ACTOR.track   a log, ACTOR.duplicate   a name, ACTOR.remove   0 or 1: as the command's edits;
///   mount.x|y|z|roll|pitch|yaw   what is not varied is 0;
///   set.KEY   of --set;
///   NAME   of any other option: lane_shift is --lane-shift.
[[nodiscard]] Variation parse_variation(const std::string& text);

struct SweepJob {
  std::string name;  // "car.move.left=-1,lane_shift=1.5"
  std::vector<std::string> words;
};

/// Every value with every other, the last key's fastest. "{}" in a word becomes the job's name. Error{kUsage}
/// for keys that come twice, more than a million jobs, and words without "{}".
[[nodiscard]] std::vector<SweepJob> sweep(const std::vector<Variation>& variations,
                                          const std::vector<std::string>& words);

/// As read_jobs() reads it, a job a line.
[[nodiscard]] std::string jobs_text(const std::vector<SweepJob>& jobs);

}  // namespace simuli::cli
