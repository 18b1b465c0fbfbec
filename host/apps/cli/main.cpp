#include "host/apps/cli/simuli.hpp"
#if __has_include("simuli_commit.hpp")
#include "simuli_commit.hpp"  // host/apps/cli/commit.cmake
#else
#define SIMULI_COMMIT ""
#endif

int main(int argc, char** argv) { return simuli::cli::run_simuli(argc, argv, SIMULI_COMMIT); }
