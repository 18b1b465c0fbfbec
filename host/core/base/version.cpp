#include "host/core/base/version.hpp"

const char* simuli::version() { return SIMULI_VERSION; }
