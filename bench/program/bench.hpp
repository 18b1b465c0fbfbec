#pragma once

namespace simuli::bench {

/// Runs the program `simuli-bench`; main() only calls this function.
[[nodiscard]] int run_bench(int argc, char** argv);

}  // namespace simuli::bench
