#pragma once
// The processes that a launcher of MPI has started, for one training.
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "optim/train/ranks/ranks.hpp"

namespace simuli::cli {

/// The value of an environment variable; null where there is none.
using Environment = std::function<const char*(const char* name)>;

struct LauncherRank {
  std::size_t index = 0;  // below count
  std::size_t count = 1;
};
/// The rank of mpirun or srun that this is (OMPI_COMM_WORLD_RANK and _SIZE; PMI_RANK and PMI_SIZE; PMIX_RANK,
/// with SLURM_NTASKS); one of one without them. Error{kUsage} for what does not fit together.
[[nodiscard]] LauncherRank rank_in(const Environment& environment);

/// Exit code of ranks that can't give the same bits.
inline constexpr int kRanksDifferExit = 7;

/// Ranks by MPI. A rank that ends without finish() takes the others with it: the launcher ends them.
class LaunchedRanks : public Ranks {
 public:
  /// Behind everything else, however it went as long as all ranks know: lets the process end in good order.
  virtual void finish() = 0;
};
/// Those of mpirun or srun (rank_in()); null without a launcher, or when this rank is the only one.
/// Error{kUsage} in a build without MPI, Error{kInternal} when MPI does not start, or has started others than
/// the environment says.
[[nodiscard]] std::unique_ptr<LaunchedRanks> launched_ranks(const Environment& environment);

/// The one of a rank that shares its machine with others (OMPI_COMM_WORLD_LOCAL_RANK, MPI_LOCALRANKID,
/// SLURM_LOCALID), each of which takes the next.
[[nodiscard]] std::string device_of_rank(const std::vector<std::string>& devices,
                                         const Environment& environment);

}  // namespace simuli::cli
