#include "host/apps/cli/train/launched_ranks.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <string_view>
#include <system_error>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/train/mpi_calls.h"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorKind::kInternal, "MPI: " + what); }

class MpiRanks final : public LaunchedRanks {
 public:
  MpiRanks(const MpiCalls& calls, LauncherRank expected) : calls_(calls) {
    int rank = 0, size = 0;
    need(calls_.start(&rank, &size));
    rank_ = static_cast<std::size_t>(rank);
    size_ = static_cast<std::size_t>(size);
    if (rank_ == expected.index && size_ == expected.count) return;
    fail(fmt::format("found rank {} of {}, expected {} of {} by the launcher's environment: of another MPI?",
                     rank_,
                     size_,
                     expected.index,
                     expected.count));
  }
  [[nodiscard]] std::size_t rank() const override { return rank_; }
  [[nodiscard]] std::size_t size() const override { return size_; }

  [[nodiscard]] std::span<const Message> all_gather(Message own) override {
    const std::uint64_t count = own.size();
    std::vector<std::uint64_t> counts(size_);
    need(calls_.gather(&count, sizeof count, counts.data()));
    others_.resize(size_);
    messages_.assign(size_, own);
    for (std::size_t from = 0; from < size_; ++from) {
      void* data = const_cast<std::byte*>(own.data());  // MPI does not write to the sender's data
      if (from != rank_) {
        others_[from].resize(counts[from]);
        messages_[from] = others_[from];
        data = others_[from].data();
      }
      need(calls_.broadcast(data, counts[from], static_cast<int>(from)));
    }
    return messages_;
  }
  void finish() override { calls_.finish(); }

 private:
  static void need(int failed) {
    if (failed != 0) fail(fmt::format("found its error {}, expected none", failed));
  }
  const MpiCalls& calls_;
  std::size_t rank_ = 0, size_ = 1;
  std::vector<Bytes> others_;  // their memory is reused
  std::vector<Message> messages_;
};

/// Returns the number in a variable; no value if it is not set.
std::optional<std::size_t> number_in(const Environment& environment, const char* name) {
  const char* const text = environment(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  std::size_t value = 0;
  const std::string_view digits(text);
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc{} || result.ptr != digits.data() + digits.size()) {
    refuse(name, text, "a whole number from 0 on");
  }
  return value;
}

#ifdef SIMULI_MPI_MODULE
const MpiCalls& mpi() {
  const fs::path module = fs::read_symlink("/proc/self/exe").parent_path() / SIMULI_MPI_MODULE;
  // Components that MPI loads need MPI's symbols in the global namespace.
  void* const handle = dlopen(module.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (handle == nullptr) fail(dlerror());
  auto* const calls = reinterpret_cast<SimuliMpiCalls*>(dlsym(handle, "simuli_mpi_calls"));
  if (calls == nullptr) fail(dlerror());
  return *calls();
}
#else
const MpiCalls& mpi() { refuse_absent("train under a launcher of MPI", "SIMULI_MPI"); }
#endif

}  // namespace

LauncherRank rank_in(const Environment& environment) {
  struct Launcher {
    const char* rank;
    const char* size;
  };
  // PMIX_RANK is last: launchers that set it together with another pair specify the size in that pair.
  for (const Launcher& launcher : {Launcher{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                   Launcher{"PMI_RANK", "PMI_SIZE"},
                                   Launcher{"PMIX_RANK", "SLURM_NTASKS"}}) {
    const std::optional<std::size_t> rank = number_in(environment, launcher.rank);
    if (!rank) continue;
    const std::optional<std::size_t> size = number_in(environment, launcher.size);
    if (!size) refuse(launcher.size, "", fmt::format("a number, together with {}", launcher.rank));
    if (*rank >= *size) {
      refuse(launcher.rank, fmt::format("{}", *rank), fmt::format("less than {}, {}", launcher.size, *size));
    }
    return {*rank, *size};
  }
  return {};
}

std::unique_ptr<LaunchedRanks> launched_ranks(const Environment& environment) {
  const LauncherRank own = rank_in(environment);
  if (own.count <= 1) return nullptr;
  return std::make_unique<MpiRanks>(mpi(), own);
}

std::string device_of_rank(const std::vector<std::string>& devices, const Environment& environment) {
  for (const char* const name : {"OMPI_COMM_WORLD_LOCAL_RANK", "MPI_LOCALRANKID", "SLURM_LOCALID"}) {
    const char* const text = environment(name);
    if (text != nullptr && *text != '\0') {
      return devices[std::strtoul(text, nullptr, 10) % devices.size()];
    }
  }
  return devices[rank_in(environment).index % devices.size()];
}

}  // namespace simuli::cli
