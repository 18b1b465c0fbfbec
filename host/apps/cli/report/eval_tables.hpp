#pragma once
// The scores of an evaluation as tables and as JSON.
#include <string>
#include <vector>

#include "host/apps/cli/base/provenance.hpp"
#include "io/base/json_reader.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

struct TextColumn {
  std::string name;
  Better better = Better::kNeither;
};
struct TextTable {
  std::string title;
  std::vector<TextColumn> header;
  std::vector<std::vector<std::string>> rows;
};

/// Held-out frames of both uses apart, errors by range, errors by kind of object: each where there is
/// something to tell.
[[nodiscard]] std::vector<TextTable> eval_tables(const EvalReport& report);
/// For a terminal: columns as wide as what stands in them, the first one to the left.
[[nodiscard]] std::string text_of(const TextTable& table);

/// With units in the key names; a value that is not a number is null.
[[nodiscard]] Json json_of(const EvalScores& scores);

/// A frame's own scores: its index in the log, sensor, time.
[[nodiscard]] Json json_of(const PictureScore& score);
[[nodiscard]] Json json_of(const SweepScore& score);

}  // namespace simuli::cli
