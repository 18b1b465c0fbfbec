#pragma once

namespace simuli::cli {

/// All of `simuli`: main() is this and nothing else.
[[nodiscard]] int run_simuli(int argc, char** argv);

}  // namespace simuli::cli
