#pragma once
#include <string>

namespace simuli::cli {

/// Runs the program `simuli`; main() only calls this function.
[[nodiscard]] int run_simuli(int argc, char** argv, const std::string& commit);

}  // namespace simuli::cli
