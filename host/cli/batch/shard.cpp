#include "host/cli/batch/shard.hpp"

#include <charconv>
#include <fmt/format.h>
#include <optional>
#include <string_view>
#include <system_error>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

std::optional<std::size_t> whole(std::string_view text) {
  std::size_t value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

[[noreturn]] void refuse_shard(const std::string& what, const std::string& found, const char* allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found \"{}\", allowed {}", what, found, allowed));
}

constexpr const char* kWhole = "a whole number from 0 on";

/// The number in a variable; nothing where it is not set.
std::optional<std::size_t> number_in(const Environment& environment, const char* name) {
  const char* const text = environment(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  const std::optional<std::size_t> value = whole(text);
  if (!value) refuse_shard(name, text, kWhole);
  return value;
}

std::size_t needed(const Environment& environment, const char* name, const char* of) {
  const std::optional<std::size_t> value = number_in(environment, name);
  if (!value) refuse_shard(name, "", fmt::format("a number beside {}, or --shard K/N", of).c_str());
  return *value;
}

Shard task_in(const Environment& environment) {
  constexpr const char* kId = "SLURM_ARRAY_TASK_ID";
  const std::optional<std::size_t> id = number_in(environment, kId);
  if (!id) return {};
  const std::size_t count = needed(environment, "SLURM_ARRAY_TASK_COUNT", kId);
  const std::size_t least = number_in(environment, "SLURM_ARRAY_TASK_MIN").value_or(0);
  const std::size_t step = number_in(environment, "SLURM_ARRAY_TASK_STEP").value_or(1);
  const bool is_in_step = step > 0 && *id >= least && (*id - least) % step == 0;
  // Of --array=1,5,9 nobody tells which of them this is.
  if (!is_in_step || (*id - least) / step >= count) {
    refuse_shard(
        kId,
        fmt::format("{}", *id),
        fmt::format(
            "one of {} from {} in steps of {} (--array=A-B or A-B:STEP), or --shard K/N", count, least, step)
            .c_str());
  }
  return {(*id - least) / step, count};
}

}  // namespace

Shard rank_in(const Environment& environment) {
  struct Launcher {
    const char* rank;
    const char* size;
  };
  // PMIX_RANK last: launchers that set it and another pair say the size there.
  for (const Launcher& launcher : {Launcher{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                   Launcher{"PMI_RANK", "PMI_SIZE"},
                                   Launcher{"PMIX_RANK", "SLURM_NTASKS"}}) {
    const std::optional<std::size_t> rank = number_in(environment, launcher.rank);
    if (!rank) continue;
    const std::size_t size = needed(environment, launcher.size, launcher.rank);
    if (*rank >= size) {
      refuse_shard(launcher.rank,
                   fmt::format("{}", *rank),
                   fmt::format("less than {}, {}", launcher.size, size).c_str());
    }
    return {*rank, size};
  }
  return {};
}

Shard parse_shard(const std::string& text) {
  const std::size_t at = text.find('/');
  if (at != std::string::npos) {
    const std::optional<std::size_t> index = whole(text.substr(0, at)), count = whole(text.substr(at + 1));
    if (index && count && *index < *count) return {*index, *count};
  }
  refuse_shard("--shard", text, "K/N, whole numbers with 0 <= K < N");
}

Shard shard_in(const Environment& environment) {
  const Shard task = task_in(environment), rank = rank_in(environment);
  return {task.index * rank.count + rank.index, task.count * rank.count};
}

}  // namespace simuli::cli
