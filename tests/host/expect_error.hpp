#pragma once
#include <gtest/gtest.h>
#include <string>

#include "host/core/base/error.hpp"

namespace simuli {

/// Expects that f throws Error of `kind` with a one-line message that contains `part`.
template <class F>
void expect_error(ErrorKind kind, const std::string& part, F&& f) {
  try {
    f();
    ADD_FAILURE() << "nothing was thrown; expected: " << part;
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.kind(), kind) << what;
    EXPECT_NE(what.find(part), std::string::npos) << "\"" << what << "\" lacks \"" << part << "\"";
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

}  // namespace simuli
