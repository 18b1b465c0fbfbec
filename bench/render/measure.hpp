#pragma once
#include <string>
#include <vector>

#include "host/core/base/spread.hpp"
#include "host/core/base/stopwatch.hpp"

namespace simuli::bench {

/// One measured number, named `<table>/<variant>/<metric>`.
struct Row {
  std::string name;
  double value = 0.0;
  std::string unit;
  double spread = 0.0;  // half the interquartile range, in `unit`
};

/// Returns the rows as a JSON array of {name, value, unit, spread}, or as a text table.
[[nodiscard]] std::string to_json(const std::vector<Row>& rows);
[[nodiscard]] std::string to_text(const std::vector<Row>& rows);

}  // namespace simuli::bench
