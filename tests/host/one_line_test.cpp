#include "host/core/base/one_line.hpp"

#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

TEST(OneLine, CharactersThatChangeWhatIsShownAreBytes) {
  EXPECT_EQ(on_one_line("a\nb\x1B[31m\x7F"), "a\\x0ab\\x1b[31m\\x7f");
  EXPECT_EQ(on_one_line("\xC2\x85"), "\\xc2\\x85");  // next line
  EXPECT_EQ(on_one_line("\xE2\x80\xAE"
                        "gpj"),
            "\\xe2\\x80\\xaegpj");  // from right to left
  EXPECT_EQ(on_one_line("\xE2\x81\xA6x"), "\\xe2\\x81\\xa6x");
  for (const char* text : {"",
                           "plain",
                           "Gr\xC3\xB6\xC3\x9F"
                           "e",
                           "\xE2\x82\xAC",
                           "\xC2\xA0",
                           "\xC2",
                           "\xE2\x80"}) {
    EXPECT_EQ(on_one_line(text), text);
  }
}

TEST(OneLine, MessagesAreOne) {
  expect_error(ErrorKind::kInput, "a\\x0ab: \\xe2\\x80\\xae: found \\xc2\\x85, allowed x", [] {
    throw_input_error("a\nb", "\xE2\x80\xAE", "\xC2\x85", "x");
  });
}

}  // namespace
}  // namespace simuli
