#pragma once
#include <string>

namespace simuli {

/// "0.1.0"
[[nodiscard]] const char* version();

/// Returns the linker's build ID of the program or library that contains this code, in hexadecimal digits;
/// unique to a build. Empty without one. SIMULI_TEST_BUILD is appended, which simulates another build in tests.
[[nodiscard]] std::string build_id();

}  // namespace simuli
