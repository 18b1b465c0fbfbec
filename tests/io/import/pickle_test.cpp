// Tests tables of pandas without Python: supported contents and errors.
#include "io/import/pandaset/pickle.hpp"

#include <gtest/gtest.h>
#include <string>

#include "io/import/pandaset/data_frame.hpp"
#include "tests/io/import/pandaset_folder.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using pandaset::DataFrame;
using pandaset::Pickle;
using pandaset::PickleKind;
using test::expect_input_error;
using test::MadeTable;
using test::PickleText;

MadeTable table() { return {{{"x", {1.5, -2.0}}, {"d", {0.0, 1.0}}}, {{"label", {"Car", "Bus \xc3\xa9"}}}}; }

void expect_refused(const std::string& bytes, const std::vector<std::string>& words) {
  expect_input_error([&] { (void)Pickle(bytes, "a.pkl"); }, words);
}

TEST(Pickle, ScalarsAndContainersAreATree) {
  PickleText p;
  p.put("(").integer(-7).put("K\x05M\x01\x02").put("\x8a\x02\xff\xff").put("\x88N");
  p.put(std::string("G\x3f\xf8\0\0\0\0\0\0", 9))
      .text("abc")
      .put(
          "]K\x01"
          "aq\x07h\x07}")
      .text("k")
      .put("K\x02st.");
  const Pickle pickle(p.bytes, "a.pkl");
  const auto& items = pickle.root().children;
  ASSERT_EQ(pickle.root().kind, PickleKind::kTuple);
  ASSERT_EQ(items.size(), 11U);
  EXPECT_EQ(pickle.at(items[0]).integer, -7);
  EXPECT_EQ(pickle.at(items[1]).integer, 5);
  EXPECT_EQ(pickle.at(items[2]).integer, 513);
  EXPECT_EQ(pickle.at(items[3]).integer, -1);
  EXPECT_EQ(pickle.at(items[4]).kind, PickleKind::kBool);
  EXPECT_EQ(pickle.at(items[5]).kind, PickleKind::kNone);
  EXPECT_EQ(pickle.at(items[6]).number, 1.5);
  EXPECT_EQ(pickle.at(items[7]).text, "abc");
  EXPECT_EQ(items[8], items[9]);  // the same list twice
  EXPECT_EQ(pickle.at(pickle.at(items[8]).children.at(0)).integer, 1);
  ASSERT_NE(pickle.find(pickle.at(items[10]), "k"), nullptr);
  EXPECT_EQ(pickle.find(pickle.at(items[10]), "other"), nullptr);
}

TEST(Pickle, BytesOfProtocol2StandAsText) {
  PickleText p;
  p.global("_codecs", "encode").text("a\xc3\xbf\xc2\x80").text("latin1").put("\x86R.");
  const Pickle pickle(p.bytes, "a.pkl");
  EXPECT_EQ(pickle.root().kind, PickleKind::kBytes);
  EXPECT_EQ(pickle.root().text, "a\xff\x80");
}

TEST(Pickle, NothingOfPythonIsRunOrMade) {
  expect_refused(PickleText().global("os", "system").text("true").put("\x85R.").bytes,
                 {"a.pkl", "byte 2", "os.system", "tables of pandas"});
  expect_refused(PickleText().text("builtins").text("eval").put("\x93.").bytes, {"builtins.eval"});
  expect_refused(PickleText().global("numpy", "ndarray\x1b[2J").put(".").bytes, {"class or function"});
  for (const char* const operation : {"P1\n", "Q", "\x82\x01", "i", "o", "\x97", "\x8f", "I1\n", "\x92"})
    expect_refused(PickleText().put(operation).bytes, {"operation"});
  expect_refused(PickleText().put("K\x01)R.").bytes, {"call", "of no class or function"});
  expect_refused(PickleText().global("numpy", "dtype").put("K\x01R.").bytes, {"call"});
}

TEST(Pickle, DamageIsRefused) {
  const std::string whole = table().pickled();
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    expect_refused(whole.substr(0, size), {"a.pkl"});
    if (::testing::Test::HasFailure()) FAIL() << size;
  }
  expect_refused(std::string("\x80\x01N.", 4), {"protocol", "2 to 5"});
  expect_refused("\x80\x03K\x01K\x02.", {"end"});
  expect_refused("\x80\x03.", {"end"});
  expect_refused("\x80\x03t.", {"no mark"});
  expect_refused(
      "\x80\x03(K\x01"
      "0"
      "0"
      "t.",
      {"no value"});
  expect_refused("\x80\x03h\x05.", {"memo", "5"});
  expect_refused(
      "\x80\x03K\x01K\x02"
      "a.",
      {"list"});
  expect_refused("\x80\x03}(K\x01u.", {"a key without a value"});
  expect_refused(
      "\x80\x03)K\x01"
      "b.",
      {"call"});
  expect_refused(
      "\x80\x03\x8a\x09"
      "123456789.",
      {"integer", "9 bytes"});
  expect_refused(PickleText().global("numpy", "dtype").put(")R}b}b.").bytes, {"state", "a second one"});
}

TEST(Pickle, CountsThatNoFileHoldsCostNothing) {
  for (const char* const operation : {"B", "X"})
    expect_refused(PickleText().put(operation).put("\xff\xff\xff\xff").bytes, {"cut short"});
  for (const char* const operation : {"\x8e", "\x8d", "\x96", "\x95"})
    expect_refused(PickleText().put(operation).put("\xff\xff\xff\xff\xff\xff\xff\xff").bytes, {"cut short"});
  std::string many = "\x80\x03(";
  many.append(Pickle::kMostValues + 1, 'N');
  expect_refused(many + "t.", {"values", "at most 4194304"});
}

TEST(DataFrame, BothLayoutsAreRead) {
  for (const bool is_old : {true, false}) {
    const DataFrame frame(table().pickled(is_old), "a.pkl");
    EXPECT_EQ(frame.rows(), 2U);
    EXPECT_EQ(frame.numbers("x"), (std::vector<double>{1.5, -2.0}));
    EXPECT_EQ(frame.numbers("d"), (std::vector<double>{0.0, 1.0}));
    EXPECT_EQ(frame.texts("label"), (std::vector<std::string>{"Car", "Bus \xc3\xa9"}));
    EXPECT_FALSE(frame.has("y"));
    expect_input_error([&] { (void)frame.numbers("y"); }, {"a.pkl", "columns", "no \"y\""});
    expect_input_error([&] { (void)frame.numbers("label"); }, {"column \"label\"", "numbers"});
    expect_input_error([&] { (void)frame.texts("x"); }, {"column \"x\"", "texts"});
  }
}

TEST(DataFrame, FilesMayBePackedOrNot) {
  const test::Scratch scratch;
  EXPECT_EQ(DataFrame(scratch.file("a.pkl", table().pickled())).rows(), 2U);
  EXPECT_EQ(DataFrame(scratch.file("a.pkl.gz", gzip(table().pickled()))).rows(), 2U);
  expect_input_error([&] { (void)DataFrame(scratch.file("b.pkl.gz", gzip("x").substr(0, 12))); },
                     {"b.pkl.gz"});
  const std::string bomb = gzip(std::string(DataFrame::kMostBytes + 1, '\0'));
  expect_input_error([&] { (void)DataFrame(scratch.file("c.pkl.gz", bomb)); }, {"c.pkl.gz", "67108864"});
}

/// Replaces the first occurrence of a text.
std::string changed(std::string bytes, const std::string& from, const std::string& to) {
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos);
  return bytes.replace(at, from.size(), to);
}

TEST(DataFrame, WhatIsNoTableIsRefused) {
  const auto refused = [](const std::string& bytes, const std::vector<std::string>& words) {
    expect_input_error([&] { (void)DataFrame(bytes, "a.pkl"); }, words);
  };
  refused("\x80\x03].", {"content", "a DataFrame"});
  refused(PickleText().global("pandas", "DataFrame").put(")\x81.").bytes, {"content"});
  refused(PickleText().global("pandas", "DataFrame").put(")\x81}b.").bytes, {"no columns"});
  const std::string whole = table().pickled();
  refused(changed(whole, "mgr_locs", "mgr_locz"), {"blocks"});
  refused(changed(whole, "0.14.1", "0.14.2"), {"BlockManager"});
  refused(changed(whole, std::string("X\x01\0\0\0<", 6), std::string("X\x01\0\0\0>", 6)), {"big endian"});
}

}  // namespace
}  // namespace simuli
