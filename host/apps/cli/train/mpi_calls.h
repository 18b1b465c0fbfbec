#pragma once
// What the program takes of MPI, from a module of its own (mpi_module.cpp): nobody else loads MPI.
#include <cstdint>

namespace simuli::cli {

/// All but the last return 0, or MPI's error code. From one thread.
struct MpiCalls {
  int (*start)(int* rank, int* size);
  /// own[bytes] of each rank -> all[size][bytes].
  int (*gather)(const void* own, std::uint64_t bytes, void* all);
  /// data[bytes] of rank `from` -> that of all.
  int (*broadcast)(void* data, std::uint64_t bytes, int from);
  void (*finish)();
};

}  // namespace simuli::cli

extern "C" {
/// The module's only symbol.
using SimuliMpiCalls = const simuli::cli::MpiCalls*();
}
