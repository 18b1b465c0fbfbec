#pragma once

namespace simuli::bench {

/// All of `simuli-bench`: main() is this and nothing else.
[[nodiscard]] int run_bench(int argc, char** argv);

}  // namespace simuli::bench
