#pragma once
#include <string>

namespace simuli {

/// "0.1.0"
[[nodiscard]] const char* version();

/// What the linker calls the program or library that this is part of, in hexadecimal digits: no other build's.
/// Empty where it has given no such number. SIMULI_TEST_BUILD is appended: another one, for tests.
[[nodiscard]] std::string build_id();

}  // namespace simuli
