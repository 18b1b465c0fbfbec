#pragma once
// The processes that a launcher of MPI has started, for one training.
#include <memory>
#include <string>
#include <vector>

#include "host/cli/batch/shard.hpp"
#include "optim/ranks/ranks.hpp"

namespace simuli::cli {

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
