// simuli_mpi.so: access to MPI, loaded if a launcher started several ranks of a training.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <algorithm>
#include <mpi.h>

#include "host/apps/cli/train/mpi_calls.h"

namespace {

constexpr std::uint64_t kMost = std::uint64_t{1} << 30U;  // MPI counts by int

int start(int* rank, int* size) {
  int provided = 0;
  // Other threads of the program read files and print progress; they do not call MPI.
  if (const int failed = MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided)) return failed;
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  if (const int failed = MPI_Comm_rank(MPI_COMM_WORLD, rank)) return failed;
  return MPI_Comm_size(MPI_COMM_WORLD, size);
}

int gather(const void* own, std::uint64_t bytes, void* all) {
  const int count = static_cast<int>(bytes);
  return MPI_Allgather(own, count, MPI_BYTE, all, count, MPI_BYTE, MPI_COMM_WORLD);
}

int broadcast(void* data, std::uint64_t bytes, int from) {
  auto* next = static_cast<char*>(data);
  while (bytes > 0) {
    const std::uint64_t part = std::min(bytes, kMost);
    if (const int failed = MPI_Bcast(next, static_cast<int>(part), MPI_BYTE, from, MPI_COMM_WORLD)) {
      return failed;
    }
    next += part;
    bytes -= part;
  }
  return MPI_SUCCESS;
}

void finish() { MPI_Finalize(); }

constexpr simuli::cli::MpiCalls kCalls{start, gather, broadcast, finish};

}  // namespace

extern "C" __attribute__((visibility("default"))) const simuli::cli::MpiCalls* simuli_mpi_calls() {
  return &kCalls;
}
