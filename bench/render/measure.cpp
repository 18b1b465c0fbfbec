#include "bench/render/measure.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace simuli::bench {

std::string to_json(const std::vector<Row>& rows) {
  // Names and units are identifiers without characters to escape.
  std::string out = "[\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& r = rows[i];
    out += fmt::format("  {{\"name\": \"{}\", \"value\": {:.6g}, \"unit\": \"{}\", \"spread\": {:.3g}}}{}\n",
                       r.name,
                       r.value,
                       r.unit,
                       r.spread,
                       i + 1 < rows.size() ? "," : "");
  }
  return out + "]\n";
}

std::string to_text(const std::vector<Row>& rows) {
  std::size_t width = 0;
  for (const Row& r : rows) width = std::max(width, r.name.size());
  std::string out;
  for (const Row& r : rows) {
    out += fmt::format("{:<{}}  {:>12.5g} {:<8} +- {:.3g}\n", r.name, width, r.value, r.unit, r.spread);
  }
  return out;
}

}  // namespace simuli::bench
