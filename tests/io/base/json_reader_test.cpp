#include "io/base/json_reader.hpp"

#include <ctime>
#include <gtest/gtest.h>

#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;

/// Reads `text` as the file "x.json".
template <class Read>
auto read(const std::string& text, Read&& use) {
  return read_json_text(text, "x.json", use);
}

TEST(JsonReader, ReadsEveryType) {
  const std::string text =
      R"({"n": 1.5, "i": -3, "t": "text", "b": true, "v": [1, 2, 3], "o": {"k": 7}, "l": [{"k": 1}, {"k": 2}]})";
  read(text, [](JsonObject& root) {
    EXPECT_EQ(root.number("n"), 1.5);
    EXPECT_EQ(root.integer("i"), -3);
    EXPECT_EQ(root.text("t"), "text");
    EXPECT_TRUE(root.boolean("b"));
    EXPECT_EQ(root.vector<3>("v"), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(root.object("o", [](JsonObject& o) { return o.integer("k"); }), 7);
    EXPECT_EQ(root.objects("l", [](JsonObject& o) { return o.integer("k"); }),
              (std::vector<std::int64_t>{1, 2}));
    EXPECT_FALSE(root.has("absent"));
  });
}

TEST(JsonReader, KeepsNanosecondsExactly) {
  const std::int64_t ns =
      read(R"({"time_ns": 1317042651106324297})", [](JsonObject& root) { return root.integer("time_ns"); });
  EXPECT_EQ(ns, 1317042651106324297);
}

TEST(JsonReader, RefusesUnknownKeysWithTheirPath) {
  const auto nested = [](JsonObject& root) {
    return root.objects("rows", [](JsonObject& row) { return row.number("elevation_rad"); });
  };
  expect_input_error(
      [&] { read(R"({"rows": [{"elevation_rad": 1}, {"elevation_rad": 1, "b": 2}]})", nested); },
      {"x.json: rows[1].b: found an unknown key, allowed elevation_rad"});
}

TEST(JsonReader, NamesBothSpellingsOfAWrongUnit) {
  const auto range = [](JsonObject& root) { return root.number("range_max_m"); };
  expect_input_error([&] { read(R"({"range_max_cm": 12000})", range); },
                     {"x.json: range_max_m: found", "range_max_cm", "allowed"});
}

TEST(JsonReader, RefusesOtherTypesAndValues) {
  const auto number = [](JsonObject& root) { (void)root.number("k", 0.0, 10.0); };
  const auto integer = [](JsonObject& root) { (void)root.integer("k", 0, 10); };
  const auto vector = [](JsonObject& root) { (void)root.vector<3>("k"); };
  expect_input_error([&] { read(R"({"k": "1"})", number); }, {"x.json: k: found \"1\", allowed a number"});
  expect_input_error([&] { read(R"({"k": 10.5})", number); }, {"k: found 10.5, allowed 0 to 10"});
  expect_input_error([&] { read(R"({"k": 1.0})", integer); },
                     {"k: found 1.0, allowed an integer from 0 to 10"});
  expect_input_error([&] { read(R"({"k": 11})", integer); }, {"found 11"});
  expect_input_error([&] { read(R"({"k": 18446744073709551615})", integer); },
                     {"found 18446744073709551615"});
  expect_input_error([&] { read(R"({"k": null})", number); }, {"found null"});
  expect_input_error([&] { read(R"({"k": [1, 2]})", vector); },
                     {"found [1,2], allowed an array of 3 numbers"});
  expect_input_error([&] { read(R"({"k": [1, 2, "c"]})", vector); }, {"allowed an array of numbers"});
  expect_input_error([&] { read(R"({"k": 1})", [](JsonObject& root) { (void)root.text("k"); }); },
                     {"allowed a string"});
  expect_input_error([&] { read(R"({"k": 1})", [](JsonObject& root) { (void)root.boolean("k"); }); },
                     {"allowed true or false"});
  expect_input_error([&] { read("[1]", number); }, {"x.json: root: found [1], allowed an object"});
}

TEST(JsonReader, RefusesBadSyntax) {
  const auto nothing = [](JsonObject&) {};
  expect_input_error([&] { read("{\"a\":\n 1,}", nothing); }, {"x.json: JSON: found", "line 2"});
  expect_input_error([&] { read("", nothing); }, {"x.json: JSON"});
  expect_input_error([&] { read("{\"a\": NaN}", nothing); }, {"x.json: JSON"});
  expect_input_error([&] { read("{\"a\": 1e999}", nothing); }, {"x.json: JSON", "1e999"});
  expect_input_error([&] { read("{} {}", nothing); }, {"x.json: JSON"});
  expect_input_error([&] { read(std::string("{}\0{}", 5), nothing); },
                     {"x.json: JSON: found a fault at byte 2"});
}

TEST(JsonReader, ReadsAsNlohmannDoes) {
  const std::string sound[] = {
      " [ 0 , -0, 12, -7, 18446744073709551615, 18446744073709551616, -9223372036854775808, "
      "-9223372036854775809]\n",
      "[0.1, -2.5e-3, 1E5, 1e+2, 0e0, 4.9e-324, 1e-400, 123456789012345678.9, -0.0, "
      "3.141592653589793115997963]",
      R"({"": {}, "a\u00e9\n\"\\": [[], "\ud83d\ude00", "caf\u00c3", true, false, null]})",
      "\xEF\xBB\xBF{\"\xC3\xA9\": \"\xE2\x82\xAC\"}",
      "\"text\"",
      "7"};
  for (const std::string& text : sound) {
    const Json read = parse_json(text, "x.json"), expected = Json::parse(text);
    EXPECT_EQ(read.dump(), expected.dump()) << text;
    for (std::size_t i = 0; read.is_array() && i < read.size(); ++i)
      EXPECT_EQ(read[i].type(), expected[i].type()) << read[i];
  }
  for (const char* text : {"01",     "1.",   ".5",      "+1",   "-",         "1e",         "1e+",      "0x1",
                           "tru",    "nul",  "[1 2]",   "[1,]", "{\"a\"}",   "{\"a\" 1}",  "{a: 1}",   "{,}",
                           "[",      "{",    "\"",      "\"\\", "\"\\x\"",   "\"\t\"",     "\"\xC3\"", "]",
                           "-1e999", "[1]]", "/*c*/ 1", "inf",  "\"\\u12\"", "\"\\ud800\""}) {
    std::string words;
    try {
      const Json none = Json::parse(std::string(text));
    } catch (const Json::exception& error) {
      words = error.what();
    }
    words = words.substr(words.find(' ') + 1);
    words = words.substr(0, words.find("last read"));  // of the file, quoted in the message
    expect_input_error([&] { (void)parse_json(text, "x.json"); }, {"x.json: JSON: found " + words});
  }
}

TEST(JsonReader, EntriesAreReadOneByOne) {
  std::vector<std::int64_t> read;
  const auto use = [&](JsonObject& entry) { read.push_back(entry.integer("k")); };
  read_json_entries(R"( [{"k": 3}, {"k": 4}] )", "x.json", use);
  read_json_entries("[]", "x.json", use);
  EXPECT_EQ(read, (std::vector<std::int64_t>{3, 4}));
  expect_input_error([&] { read_json_entries(R"([{"k": 3}, {"k": 4, "b": 1}])", "x.json", use); },
                     {"x.json: [1].b: found an unknown key"});
  expect_input_error([&] { read_json_entries(R"({"k": 3})", "x.json", use); },
                     {"x.json: root: found {\"k\":3}, allowed an array"});
  for (const char* text : {"[{\"k\": 3},]", "[{\"k\": 3}", "[{\"k\": 3}] 1", ""})
    expect_input_error([&] { read_json_entries(text, "x.json", use); }, {"x.json: JSON: found"});
}

TEST(JsonReader, RefusesWhatNestsTooDeep) {
  const auto nothing = [](JsonObject& root) { root.ignore_other_keys(); };
  const auto nested = [](int levels) {
    const auto n = static_cast<std::size_t>(levels);
    return "{\"a\":" + std::string(n, '[') + std::string(n, ']') + "}";
  };
  read(nested(63), nothing);
  // Complete, truncated, and of objects: none overflows the stack.
  const std::string deep = nested(100'000);
  expect_input_error([&] { read(deep, nothing); }, {"x.json: JSON: found more than 64 levels"});
  expect_input_error([&] { read(deep.substr(5), nothing); }, {"found more than 64 levels"});
  expect_input_error([&] { read(std::string(500'000, '['), nothing); }, {"found more than 64 levels"});
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  expect_input_error([&] { read(objects, nothing); }, {"found more than 64 levels"});
}

TEST(JsonReader, MessagesStayShortWhateverTheFileHolds) {
  constexpr std::size_t kMost = 600;
  const auto length = [](const std::string& text, const auto& use) {
    try {
      read(text, use);
    } catch (const Error& error) {
      return std::string(error.what()).size();
    }
    return std::string::npos;
  };
  const auto number = [](JsonObject& root) { (void)root.number("a"); };
  const std::string filler(100'000, 'x');
  EXPECT_LT(length("{\"a\": \"" + filler + "\"}", number), kMost);
  EXPECT_LT(length("{\"a\": [\"" + filler + "\"]}", number), kMost);
  EXPECT_LT(length("{\"a\": {\"" + filler + "\": 1}}", number), kMost);
  EXPECT_LT(length("{\"a\": 1, \"" + filler + "\": 1}", number), kMost);
  EXPECT_LT(length("{\"" + filler + "\": 1}", number), kMost);
  EXPECT_LT(length("{\"a\": \"" + filler, number), kMost);
  std::string keys = "{\"b\": 1";
  for (int i = 0; i < 10'000; ++i) keys += ", \"" + std::to_string(i) + "\": 1";
  EXPECT_LT(length(keys + "}", number), kMost);
}

TEST(JsonReader, TakesTimeInProportionToALongListOrObject) {
  // Tables of nuScenes have 2.6 million entries. With a linear search per entry, eight times as many would
  // take 64 times as long.
  const auto seconds = [](int count, bool keyed) {
    std::string text = keyed ? "{" : "{\"list\": [";
    for (int i = 0; i < count; ++i) {
      if (i > 0) text += ',';
      if (keyed) text += '"' + std::to_string(i) + "\": ";
      text += R"({"a": "b", "c": 1})";
    }
    text += keyed ? "}" : "]}";
    const std::clock_t start = std::clock();
    (void)parse_json(text, "x.json");
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  for (const bool keyed : {false, true}) {
    EXPECT_LT(seconds(160'000, keyed), 32.0 * seconds(20'000, keyed) + 0.1) << keyed;
  }
}

TEST(JsonReader, RefusesAKeyThatStandsTwice) {
  const auto number = [](JsonObject& root) { (void)root.number("a"); };
  expect_input_error([&] { read(R"({"a": 1, "a": 2})", number); }, {"x.json: \"a\": found the key twice"});
  // The same key in another object is allowed.
  const auto nested = [](JsonObject& root) {
    return root.object("a", [](JsonObject& o) { return o.number("a"); });
  };
  EXPECT_EQ(read(R"({"a": {"a": 3}})", nested), 3.0);
}

TEST(JsonReader, LeavesOtherKeysOnlyWhenToldTo) {
  const auto number = [](JsonObject& root) {
    root.ignore_other_keys();
    return root.number("a");
  };
  EXPECT_EQ(read(R"({"a": 1, "note": "of another program"})", number), 1.0);
}

}  // namespace
}  // namespace simuli
