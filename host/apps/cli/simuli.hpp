#pragma once
#include <string>

namespace simuli::cli {

/// All of `simuli`: main() is this and nothing else.
[[nodiscard]] int run_simuli(int argc, char** argv, const std::string& commit);

}  // namespace simuli::cli
