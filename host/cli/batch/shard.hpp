#pragma once
// Which part of the jobs a process does.
#include <cstddef>
#include <functional>
#include <string>

namespace simuli::cli {

struct Shard {
  std::size_t index = 0;  // below count
  std::size_t count = 1;
};

/// "K/N" with 0 <= K < N. Error{kUsage} for anything else.
[[nodiscard]] Shard parse_shard(const std::string& text);

/// The value of an environment variable; null where there is none.
using Environment = std::function<const char*(const char* name)>;
/// The rank of mpirun or srun that this is (OMPI_COMM_WORLD_RANK and _SIZE; PMI_RANK and PMI_SIZE; PMIX_RANK,
/// with SLURM_NTASKS); everything without them. Error{kUsage} for what does not fit together.
[[nodiscard]] Shard rank_in(const Environment& environment);
/// As the launcher says: a rank (rank_in()), a task of a Slurm array (SLURM_ARRAY_TASK_ID, _COUNT, _MIN,
/// _STEP), or a rank within such a task; everything without a launcher. Error{kUsage} for what does not fit
/// together.
[[nodiscard]] Shard shard_in(const Environment& environment);

}  // namespace simuli::cli
