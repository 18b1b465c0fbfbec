#pragma once
// Scores of an evaluation as tables and as JSON.
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

/// Returns the tables of scores by use of held-out frames, by sensor, by range and by kind of object, without the empty
/// ones.
[[nodiscard]] std::vector<TextTable> eval_tables(const EvalReport& report);
/// Returns the table for a terminal, with aligned columns; the first one is left-justified.
[[nodiscard]] std::string text_of(const TextTable& table);

/// Returns the report as JSON, with units in the key names; a number that is not finite is null.
[[nodiscard]] Json json_of(const EvalReport& report);

}  // namespace simuli::cli
