#pragma once
#include <string>

namespace simuli::cli {

/// What tells this program from any other: version, commit and, where the linker has given one, the number of
/// the build. SIMULI_TEST_BUILD is appended: another one, for tests.
[[nodiscard]] std::string program_build(const std::string& commit);

}  // namespace simuli::cli
