#include "bench/render/measure.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace simuli::bench {

Spread spread_of(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(samples.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, samples.size() - 1);
    const double part = place - static_cast<double>(low);
    return (1.0 - part) * samples[low] + part * samples[high];
  };
  return {at(0.5), (at(0.75) - at(0.25)) / 2.0};
}

double time_ms(const std::function<void()>& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

std::string to_json(const std::vector<Row>& rows) {
  // Names and units are our own identifiers: nothing in them needs escaping.
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
