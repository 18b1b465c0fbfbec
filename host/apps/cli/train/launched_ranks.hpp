#pragma once
// Processes of an MPI launcher that share one training.
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "optim/train/ranks/ranks.hpp"

namespace simuli::cli {

/// Returns the value of an environment variable; null if it is not set.
using Environment = std::function<const char*(const char* name)>;

struct LauncherRank {
  std::size_t index = 0;  // less than count
  std::size_t count = 1;
};
/// Returns this process's rank under mpirun or srun (OMPI_COMM_WORLD_RANK and _SIZE; PMI_RANK and PMI_SIZE;
/// PMIX_RANK with SLURM_NTASKS); rank 0 of 1 without them. Throws Error{kUsage} for contradicting values.
[[nodiscard]] LauncherRank rank_in(const Environment& environment);

/// Exit code of ranks that cannot produce the same bits.
inline constexpr int kRanksDifferExit = 7;

/// Ranks by MPI. If a rank ends without finish(), the launcher ends all ranks.
class LaunchedRanks : public Ranks {
 public:
  /// Ends MPI; the last call, after success or an error that all ranks know, so that the process ends normally.
  virtual void finish() = 0;
};
/// Returns the ranks of mpirun or srun (rank_in()); null without a launcher or with a single rank. Throws
/// Error{kUsage} in a build without MPI, Error{kInternal} if MPI does not start or its number of ranks differs
/// from the environment's.
[[nodiscard]] std::unique_ptr<LaunchedRanks> launched_ranks(const Environment& environment);

/// Returns the device of a rank that shares its machine with other ranks (OMPI_COMM_WORLD_LOCAL_RANK,
/// MPI_LOCALRANKID, SLURM_LOCALID); local rank i uses device i, modulo their number.
[[nodiscard]] std::string device_of_rank(const std::vector<std::string>& devices,
                                         const Environment& environment);

}  // namespace simuli::cli
