#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <sstream>
#include <string_view>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestText_bytes = std::size_t{64} << 20U;

/// Parses a field of digits.
bool parse_digits(std::string_view text, int& value) {
  for (const char c : text) {
    if (c < '0' || c > '9') return false;
  }
  return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
}

bool parse_timestamp(std::string_view text, std::int64_t& ns) {
  using namespace std::chrono;
  constexpr std::string_view kForm = "YYYY-MM-DD HH:MM:SS";
  if (text.size() < kForm.size()) return false;
  for (const std::size_t i : {4U, 7U, 10U, 13U, 16U}) {
    if (text[i] != kForm[i]) return false;
  }
  int y = 0, mo = 0, d = 0, h = 0, mi = 0, s = 0;
  if (!parse_digits(text.substr(0, 4), y) || !parse_digits(text.substr(5, 2), mo) ||
      !parse_digits(text.substr(8, 2), d) || !parse_digits(text.substr(11, 2), h) ||
      !parse_digits(text.substr(14, 2), mi) || !parse_digits(text.substr(17, 2), s)) {
    return false;
  }
  int fraction_ns = 0;
  std::string_view fraction = text.substr(kForm.size());
  if (!fraction.empty()) {
    fraction.remove_prefix(1);
    if (text[kForm.size()] != '.' || fraction.empty() || fraction.size() > 9) return false;
    std::string nine_digits(fraction);
    nine_digits.resize(9, '0');
    if (!parse_digits(nine_digits, fraction_ns)) return false;
  }
  const year_month_day date{year(y), month(static_cast<unsigned>(mo)), day(static_cast<unsigned>(d))};
  // int64 nanoseconds end in 2262; no log has such a date.
  if (!date.ok() || y < 1900 || y > 2200 || h > 23 || mi > 59 || s > 59) return false;
  const nanoseconds since_1970 =
      sys_days(date).time_since_epoch() + hours(h) + minutes(mi) + seconds(s) + nanoseconds(fraction_ns);
  ns = since_1970.count();
  return true;
}

}  // namespace

std::vector<std::pair<std::size_t, std::string>> numbered_lines(const fs::path& file) {
  std::istringstream in(read_file(file, kLargestText_bytes));
  std::vector<std::pair<std::size_t, std::string>> lines;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") != std::string::npos) lines.emplace_back(number, line);
  }
  return lines;
}

std::vector<std::optional<std::int64_t>> read_lines_ns(const fs::path& file) {
  std::vector<std::optional<std::int64_t>> times_ns;
  for (const auto& [number, line] : numbered_lines(file)) {
    std::int64_t ns = 0;
    if (!parse_timestamp(line, ns)) {
      throw_input_error(file.string(),
                        fmt::format("line {}", number),
                        '"' + line.substr(0, 40) + '"',
                        "YYYY-MM-DD HH:MM:SS with up to 9 decimals");
    }
    times_ns.resize(number);
    times_ns.back() = ns;
  }
  return times_ns;
}

std::vector<std::size_t> take_disordered(std::vector<std::optional<std::int64_t>>& times_ns) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  // For each length, the increasing sequence with the smallest last time; and the predecessor of each time.
  std::vector<std::size_t> ends, before(times_ns.size(), kNone);
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    if (!times_ns[i]) continue;
    const auto end =
        std::lower_bound(ends.begin(), ends.end(), *times_ns[i], [&](std::size_t a, std::int64_t t) {
          return *times_ns[a] < t;
        });
    if (end != ends.begin()) before[i] = *std::prev(end);
    if (end == ends.end())
      ends.push_back(i);
    else
      *end = i;
  }
  std::vector<bool> is_kept(times_ns.size(), false);
  for (std::size_t i = ends.empty() ? kNone : ends.back(); i != kNone; i = before[i]) is_kept[i] = true;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    if (!times_ns[i] || is_kept[i]) continue;
    times_ns[i].reset();
    taken.push_back(i);
  }
  return taken;
}

std::vector<std::int64_t> read_timestamps_ns(const fs::path& file) {
  std::vector<std::int64_t> times_ns;
  for (const std::optional<std::int64_t>& time_ns : read_lines_ns(file)) {
    if (time_ns) times_ns.push_back(*time_ns);
  }
  return times_ns;
}

std::map<std::string, std::string> read_key_lines(const fs::path& file) {
  std::map<std::string, std::string> values;
  for (const auto& [number, line] : numbered_lines(file)) {
    const std::size_t colon = line.find(':');
    const bool is_new =
        colon != std::string::npos && values.emplace(line.substr(0, colon), line.substr(colon + 1)).second;
    if (!is_new) {
      throw_input_error(file.string(),
                        fmt::format("line {}", number),
                        '"' + line.substr(0, 40) + '"',
                        "\"key: values\", each key once");
    }
  }
  return values;
}

std::vector<double> parse_numbers(const std::string& text,
                                  std::size_t count,
                                  const fs::path& file,
                                  const std::string& field) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
    if (at == end) break;
    double number = 0.0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || !std::isfinite(number)) {
      const std::string word(at, std::find_if(at, end, [](char c) { return c == ' ' || c == '\n'; }));
      throw_input_error(file.string(), field, '"' + word.substr(0, 40) + '"', "finite numbers");
    }
    numbers.push_back(number);
    at = next;
  }
  if (numbers.size() != count) {
    throw_input_error(
        file.string(), field, fmt::format("{} numbers", numbers.size()), fmt::format("{} numbers", count));
  }
  return numbers;
}

}  // namespace simuli::kitti
