#include "host/core/base/close_names.hpp"

#include <gtest/gtest.h>

namespace simuli {
namespace {

using Names = std::vector<std::string>;
const Names kKnown{"acme_top16", "acme_top32", "acme_side", "borealis_top128", "plain"};

TEST(CloseNames, TypingErrors) {
  EXPECT_EQ(close_names("plian", kKnown), Names{"plain"});
  EXPECT_EQ(close_names("acme_sdie", kKnown), Names{"acme_side"});
  EXPECT_EQ(close_names("acme_top3", kKnown).front(), "acme_top32");
  EXPECT_EQ(close_names("eavl", {"eval"}), Names{"eval"});  // two swapped letters are one error
  EXPECT_EQ(close_names("Plain", kKnown), Names{"plain"});
  EXPECT_EQ(close_names("acme", {"ACME_SIDE"}), Names{"ACME_SIDE"});
}

TEST(CloseNames, ShortNamesAreNotLikeAllOthers) {
  EXPECT_TRUE(close_names("nope", {"ncore_waymo_top", "none_of_it", "rope_walk"}).empty());
  EXPECT_EQ(close_names("nome", {"none", "home_side"}), Names{"none"});
}

TEST(CloseNames, AsAQuestion) {
  EXPECT_EQ(did_you_mean("plian", kKnown), "did you mean plain? ");
  EXPECT_EQ(did_you_mean("acme_top12", kKnown), "did you mean acme_top16, acme_top32? ");
  EXPECT_EQ(did_you_mean("zzzzzz", kKnown), "");
  EXPECT_EQ(did_you_mean("plian", {"plain"}), "");  // the message lists the allowed values anyway
}

TEST(CloseNames, PartsOfANameAndItsEnd) {
  EXPECT_EQ(close_names("borealis", kKnown), Names{"borealis_top128"});
  EXPECT_EQ(close_names("top128", kKnown).front(), "borealis_top128");
  EXPECT_EQ(close_names("top128x", kKnown).front(), "borealis_top128");
  EXPECT_EQ(close_names("opactiy", {"camera.rate.opacity"}), Names{"camera.rate.opacity"});
}

TEST(CloseNames, NothingCloseAndNotTooMany) {
  EXPECT_TRUE(close_names("zzzzzz", kKnown).empty());
  EXPECT_TRUE(close_names("", kKnown).empty());
  EXPECT_TRUE(close_names("x", kKnown).empty());
  EXPECT_TRUE(close_names("plain", {}).empty());
  EXPECT_EQ(close_names("acme", kKnown, 2).size(), 2U);
}

}  // namespace
}  // namespace simuli
