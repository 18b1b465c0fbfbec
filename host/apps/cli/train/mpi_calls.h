#pragma once
// MPI functions of the program, from a separate module (mpi_module.cpp), so that only launched trainings load
// MPI.
#include <cstdint>

namespace simuli::cli {

/// All functions but the last return 0 or MPI's error code. Call them from one thread.
struct MpiCalls {
  int (*start)(int* rank, int* size);
  /// Gathers own[bytes] of each rank into all[size][bytes].
  int (*gather)(const void* own, std::uint64_t bytes, void* all);
  /// Copies data[bytes] of rank `from` to all ranks.
  int (*broadcast)(void* data, std::uint64_t bytes, int from);
  void (*finish)();
};

}  // namespace simuli::cli

extern "C" {
/// The only symbol of the module.
using SimuliMpiCalls = const simuli::cli::MpiCalls*();
}
