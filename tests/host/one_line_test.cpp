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
  EXPECT_EQ(on_one_line("\xEF\xBB\xBF# x"), "\\xef\\xbb\\xbf# x");  // of UTF-8 as Windows writes it
  for (const char* text : {"",
                           "plain",
                           "Gr\xC3\xB6\xC3\x9F"
                           "e",
                           "\xE2\x82\xAC",
                           "\xC2\xA0",
                           "\xED\x9F\xBF",
                           "\xF0\x9F\x9A\x97",
                           "\xF4\x8F\xBF\xBF"}) {
    EXPECT_EQ(on_one_line(text), text);
  }
}

TEST(OneLine, WhatIsNoUtf8IsBytes) {
  EXPECT_EQ(on_one_line("\x89MCAP"), "\\x89MCAP");
  EXPECT_EQ(on_one_line("caf\xE9 au lait"), "caf\\xe9 au lait");  // Latin-1
  EXPECT_EQ(on_one_line("\xC2"), "\\xc2");                        // cut off
  EXPECT_EQ(on_one_line("\xE2\x80"), "\\xe2\\x80");
  EXPECT_EQ(on_one_line("\xF0\x9F\x9A!"), "\\xf0\\x9f\\x9a!");
  EXPECT_EQ(on_one_line("\xC0\x8A"), "\\xc0\\x8a");                    // a line feed, too long
  EXPECT_EQ(on_one_line("\xED\xA0\x80"), "\\xed\\xa0\\x80");           // half of UTF-16
  EXPECT_EQ(on_one_line("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond the last
}

TEST(OneLine, MessagesAreOne) {
  expect_error(ErrorKind::kInput, "a\\x0ab: \\xe2\\x80\\xae: found \\xc2\\x85, allowed x", [] {
    throw_input_error("a\nb", "\xE2\x80\xAE", "\xC2\x85", "x");
  });
  expect_error(ErrorKind::kUsage, "no\\x00 key\\x0a", [] {
    throw Error(ErrorKind::kUsage, std::string("no\0 key\n", 9));
  });
  const std::string log = "a.cl:1:\n  error\n";
  EXPECT_EQ(Error(ErrorKind::kKernel, log).what(), log);  // a driver's own lines
}

}  // namespace
}  // namespace simuli
