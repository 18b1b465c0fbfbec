#include "host/core/base/names.hpp"

#include <gtest/gtest.h>
#include <string>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

const std::string kNoNames[] = {"",
                                ".",
                                "..",
                                "../../x",
                                ".hidden",
                                "/etc/x",
                                "a/b",
                                "a\\b",
                                "a\nb",
                                std::string("a\0b", 3),
                                "\x7F",
                                "\xC2\x85 next line",
                                "\xE2\x80\xAE turned",
                                std::string(129, 'x')};

TEST(Names, WhatLeadsOutOfAFolderIsNone) {
  for (const std::string& name : kNoNames) {
    expect_error(ErrorKind::kInput, "x.json: cameras[0].name: found \"", [&] {
      need_name(name, "x.json", "cameras[0].name");
    });
  }
  for (const std::string& name : {std::string("front"),
                                  std::string("hesai_xt32@20"),
                                  std::string("Kamera vorn, 2"),
                                  std::string("\xC3\xBC\xE2\x82\xAC"),
                                  std::string("a..b"),
                                  std::string(128, 'x')}) {
    EXPECT_NO_THROW(need_name(name, "x.json", "name"));
  }
}

TEST(Names, AreMadeOfAnything) {
  EXPECT_EQ(name_from("../../x"), "_._.._x");
  EXPECT_EQ(name_from("2011_09_26"), "2011_09_26");
  EXPECT_EQ(name_from(""), "_");
  for (const std::string& text : kNoNames) EXPECT_NO_THROW(need_name(name_from(text), "", "")) << text;
  // A character is not cut.
  std::string umlauts;
  for (int i = 0; i < 100; ++i) umlauts += "\xC3\xBC";
  EXPECT_EQ(name_from('x' + umlauts), 'x' + umlauts.substr(0, 126));
}

}  // namespace
}  // namespace simuli
