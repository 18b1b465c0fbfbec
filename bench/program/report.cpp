#include "bench/program/report.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/base/version.hpp"
#include "host/cli/draw/html_report.hpp"

namespace simuli::bench {

void write_report(const std::filesystem::path& file, const std::string& title, const std::vector<Row>& rows) {
  HtmlReport html(title, std::string("simuli ") + version());
  std::vector<std::vector<std::string>> cells;
  std::string table;
  const auto flush = [&] {
    if (cells.empty()) return;
    html.heading(table);
    html.table({"measured", "value", "unit", "+-"}, cells);
    cells.clear();
  };
  for (const Row& row : rows) {
    const std::string name = row.name.substr(0, row.name.rfind('/'));
    if (name != table) flush();
    table = name;
    cells.push_back({row.name.substr(std::min(row.name.size(), name.size() + 1)),
                     fmt::format("{:.5g}", row.value),
                     row.unit,
                     row.spread > 0.0 ? fmt::format("{:.2g}", row.spread) : ""});
  }
  flush();
  html.write(file);
}

}  // namespace simuli::bench
