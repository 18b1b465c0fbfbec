#pragma once
#include <string>
#include <vector>

#include "host/core/base/spread.hpp"
#include "host/core/base/stopwatch.hpp"

namespace simuli::bench {

/// One measured number. Names read `<table>/<variant>/<metric>`.
struct Row {
  std::string name;
  double value = 0.0;
  std::string unit;
  double spread = 0.0;  // half the distance of the quartiles, in the unit
};

/// The rows as a JSON array of {name, value, unit, spread}, and as a table for people.
[[nodiscard]] std::string to_json(const std::vector<Row>& rows);
[[nodiscard]] std::string to_text(const std::vector<Row>& rows);

}  // namespace simuli::bench
