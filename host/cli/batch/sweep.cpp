#include "host/cli/batch/sweep.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/names.hpp"
#include "host/base/split.hpp"

namespace simuli::cli {
namespace {

constexpr std::size_t kMostJobs = 1'000'000;

[[noreturn]] void refuse_vary(const std::string& found, const std::string& allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("--vary: found \"{}\", allowed {}", found, allowed));
}

std::optional<double> finite(const std::string& text) {
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = result.ec == std::errc{} && result.ptr == text.data() + text.size();
  return is_whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// As one would write it: 0.3 for three steps of 0.1.
std::string number_text(double value) { return fmt::format("{:.10g}", value == 0.0 ? 0.0 : value); }

/// Nothing where these are no three numbers.
std::optional<std::vector<std::string>> range_values(const std::string& key, const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 3) return std::nullopt;
  std::array<double, 3> range{};
  for (std::size_t k = 0; k < range.size(); ++k) {
    const std::optional<double> value = finite(parts[k]);
    if (!value) return std::nullopt;
    range[k] = *value;
  }
  const auto [first, last, step] = range;
  const double steps = (last - first) / step;
  const bool is_allowed = step != 0.0 && steps >= 0.0 && steps < static_cast<double>(kMostJobs);
  if (!is_allowed)
    refuse_vary(key + '=' + text, "FIRST:LAST:STEP, steps that lead from the first to the last");
  std::vector<std::string> values;
  // A hair more of a step, so that 0:1:0.1 includes 1.
  for (int i = 0; i <= steps + 1e-6; ++i) {
    const double value = first + i * step;
    values.push_back(number_text(std::abs(value) < 1e-9 * std::abs(step) ? 0.0 : value));
  }
  return values;
}

/// What a job's variations say together: parts of one option's value come from several keys.
class Edit {
 public:
  /// `parts` of the option's value for what `of` names; those that no key sets are `rest`.
  std::string& part(const std::string& option,
                    const std::string& of,
                    std::size_t index,
                    std::vector<std::string> rest) {
    for (Parted& known : parted_) {
      if (known.option == option && known.of == of) return known.parts[index];
    }
    parted_.push_back({option, of, std::move(rest)});
    return parted_.back().parts[index];
  }
  void add(const std::string& option, const std::string& value) {
    words_.push_back(option);
    words_.push_back(value);
  }
  [[nodiscard]] std::vector<std::string> words() const {
    std::vector<std::string> words = words_;
    for (const Parted& each : parted_) {
      words.push_back(each.option);
      const char* const separator = each.option == "--retime" ? ":" : ",";
      words.push_back(each.of + fmt::format("{}", fmt::join(each.parts, separator)));
    }
    return words;
  }

 private:
  struct Parted {
    std::string option;
    std::string of;
    std::vector<std::string> parts;
  };
  std::vector<std::string> words_;
  std::vector<Parted> parted_;
};

std::size_t place_in(const std::vector<std::string>& names, const std::string& name, const std::string& key) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) refuse_vary(key, fmt::format("{} at its end", fmt::join(names, ", ")));
  return static_cast<std::size_t>(at - names.begin());
}

const std::vector<std::string> kAxes{"forward", "left", "up"};
const std::vector<std::string> kMountParts{"x", "y", "z", "roll", "pitch", "yaw"};
const std::vector<std::string> kRetimeParts{"rate", "delay"};
const std::vector<std::string> kWholeEdits{"turn", "resize", "track", "duplicate", "remove"};

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// ACTOR.EDIT or ACTOR.EDIT.PART. Actors' names may have dots, too.
void vary_actor(Edit& edit, const std::string& key, const std::string& value) {
  const std::size_t dot = key.rfind('.');
  const std::string last = key.substr(dot + 1), front = key.substr(0, dot);
  if (has(kWholeEdits, last)) {
    if (last != "remove") return edit.add("--" + last, front + ':' + value);
    if (value != "0" && value != "1") refuse_vary(key + '=' + value, "0 or 1");
    if (value == "1") edit.add("--remove", front);
    return;
  }
  const std::size_t before = front.rfind('.');
  const std::string name = front.substr(0, before);
  const std::string kind = before == std::string::npos ? "" : front.substr(before + 1);
  if (kind == "move") {
    edit.part("--move", name + ':', place_in(kAxes, last, key), {"0", "0", "0"}) = value;
  } else if (kind == "retime") {
    edit.part("--retime", name + ':', place_in(kRetimeParts, last, key), {"1", "0"}) = value;
  } else {
    refuse_vary(key,
                "ACTOR.move.forward|left|up, ACTOR.turn, ACTOR.resize, ACTOR.retime.rate|delay, "
                "ACTOR.track, ACTOR.duplicate, ACTOR.remove, mount.PART, set.KEY or an option's name");
  }
}

void vary(Edit& edit, const std::string& key, const std::string& value) {
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos) {
    std::string option = "--" + key;
    std::replace(option.begin(), option.end(), '_', '-');
    return edit.add(option, value);
  }
  const std::string first = key.substr(0, dot), rest = key.substr(dot + 1);
  if (first == "set") return edit.add("--set", rest + '=' + value);
  if (first != "mount") return vary_actor(edit, key, value);
  edit.part("--mount", "", place_in(kMountParts, rest, key), std::vector<std::string>(6, "0")) = value;
}

std::string named(std::string word, const std::string& name) {
  constexpr std::string_view kPlace = "{}";
  for (std::size_t at = word.find(kPlace); at != std::string::npos;
       at = word.find(kPlace, at + name.size())) {
    word.replace(at, kPlace.size(), name);
  }
  return word;
}

SweepJob sweep_job(const std::vector<Variation>& variations,
                   const std::vector<std::size_t>& at,
                   const std::vector<std::string>& words) {
  Edit edit;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < variations.size(); ++k) {
    const std::string& value = variations[k].values[at[k]];
    names.push_back(variations[k].key + '=' + value);
    vary(edit, variations[k].key, value);
  }
  SweepJob job{name_from(fmt::format("{}", fmt::join(names, ","))), {}};
  for (const std::string& word : words) job.words.push_back(named(word, job.name));
  for (std::string& word : edit.words()) job.words.push_back(std::move(word));
  return job;
}

}  // namespace

Variation parse_variation(const std::string& text) {
  const std::size_t at = text.find('=');
  // What --set varies has a '=' of the file's own behind its key.
  if (at == std::string::npos || at == 0) refuse_vary(text, "KEY=A,B,C or KEY=FIRST:LAST:STEP");
  Variation variation{text.substr(0, at), {}};
  const std::string values = text.substr(at + 1);
  variation.values = range_values(variation.key, values).value_or(split(values, ','));
  std::set<std::string> known;
  for (const std::string& value : variation.values) {
    if (value.empty()) refuse_vary(text, "a value between commas");
    if (!known.insert(value).second) refuse_vary(text, "each value once");
  }
  return variation;
}

std::vector<SweepJob> sweep(const std::vector<Variation>& variations, const std::vector<std::string>& words) {
  std::set<std::string> keys;
  std::size_t count = 1;
  for (const Variation& each : variations) {
    if (!keys.insert(each.key).second) refuse_vary(each.key, "each key once");
    if (each.values.size() > kMostJobs / count) refuse_vary(each.key, "at most a million jobs");
    count *= each.values.size();
  }
  if (std::none_of(words.begin(), words.end(), [](const std::string& word) {
        return word.find("{}") != std::string::npos;
      })) {
    refuse_vary(fmt::format("{}", fmt::join(words, " ")), "{} in its output's name, for the job's own name");
  }
  std::vector<SweepJob> jobs;
  std::vector<std::size_t> at(variations.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    jobs.push_back(sweep_job(variations, at, words));
    for (std::size_t k = variations.size(); k-- > 0;) {
      if (++at[k] < variations[k].values.size()) break;
      at[k] = 0;
    }
  }
  return jobs;
}

std::string jobs_text(const std::vector<SweepJob>& jobs) {
  std::string text = "{\"format\": \"simuli batch\", \"version\": 1, \"jobs\": [";
  for (const SweepJob& job : jobs) {
    const nlohmann::ordered_json json = {{"name", job.name}, {"run", job.words}};
    text += &job == &jobs.front() ? "\n  " : ",\n  ";
    text += json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  }
  return text + "\n]}\n";
}

}  // namespace simuli::cli
