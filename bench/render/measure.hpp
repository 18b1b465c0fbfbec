#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace simuli::bench {

/// One measured number. Names read `<table>/<variant>/<metric>`.
struct Row {
  std::string name;
  double value = 0.0;
  std::string unit;
  double spread = 0.0;  // half the distance of the quartiles, in the unit
};

/// Median and half the distance of the quartiles of at least one sample.
struct Spread {
  double median = 0.0;
  double half_iqr = 0.0;
};
[[nodiscard]] Spread spread_of(std::vector<double> samples);

/// Milliseconds that f takes.
[[nodiscard]] double time_ms(const std::function<void()>& f);

/// The rows as a JSON array of {name, value, unit, spread}, and as a table for people.
[[nodiscard]] std::string to_json(const std::vector<Row>& rows);
[[nodiscard]] std::string to_text(const std::vector<Row>& rows);

}  // namespace simuli::bench
