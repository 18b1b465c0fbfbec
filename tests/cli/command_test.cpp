// Command lines as the commands describe them.
#include "host/apps/cli/base/command.hpp"

#include <gtest/gtest.h>
#include <new>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "host/apps/cli/base/crash.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/core/base/error.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli::cli {
namespace {

struct Values {
  std::string text = "some";
  std::filesystem::path file;
  int count = 3;
  std::int64_t many = 4;
  std::size_t size = 5;
  double length_m = 0.25;
  std::vector<std::string> names, parts{"preset"}, levels;
  bool flag = false, other = true;
};

class CommandTest : public testing::Test {
 protected:
  CommandTest() {
    line_.root().flag("--json", json_, "data as JSON");
    line_.root().option("--device", device_, "part of its name");
    line_.root().require_command();
    const Command sub = line_.root().command("draw", "draws something");
    sub.option("FILE", values_.file, "what is drawn").required();
    sub.option("--text", values_.text, "a text").one_of({"some", "other"}).with_default();
    count_ = std::make_unique<Option>(sub.option("--count", values_.count, "how many").range(1, 9));
    sub.option("--many", values_.many, "more").range(std::int64_t{1}, std::int64_t{1} << 40).with_default();
    sub.option("--size",
               values_.size,
               "its size, of which more can be said than fits in a line of a terminal, so that it goes on in "
               "the next one, and on");
    sub.option("--stamp", values_.many, "without a range");
    sub.option("--length", values_.length_m, "m").positive().with_default();
    sub.option("--names", values_.names, "of all").answers("help", [this] { ++answers_; });
    sub.option("--parts", values_.parts, "of it").comma_separated();
    sub.option(
        "--level", [this](const std::string& text) { values_.levels.push_back(text); }, "of care");
    sub.flag("--flag", values_.flag, "says yes");
    sub.flag("--other,!--no-other", values_.other, "says yes or no");
    sub.run([this] { ++runs_; });
    line_.add_foreign("far", "another program", [this](const std::vector<std::string>& arguments) {
      foreign_ = arguments;
      ++runs_;
    });
  }

  bool parse(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "program");
    return line_.parse(static_cast<int>(arguments.size()), arguments.data());
  }
  /// What the arguments are refused with; empty: they are not.
  std::string refusal(const std::vector<const char*>& arguments) {
    try {
      parse(arguments);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      return error.what();
    }
    return {};
  }
  std::string help(const std::vector<const char*>& arguments) {
    testing::internal::CaptureStdout();
    EXPECT_FALSE(parse(arguments));
    return testing::internal::GetCapturedStdout();
  }

  CommandLine line_{"program", "does things", [] { return std::string("program 1.2"); }};
  Values values_;
  bool json_ = false;
  std::string device_;
  std::unique_ptr<Option> count_;
  std::vector<std::string> foreign_;
  int runs_ = 0, answers_ = 0;
};

TEST_F(CommandTest, OptionsSetWhatTheyNameAndNothingElse) {
  ASSERT_TRUE(
      parse({"draw", "a b", "--many", "99999999999", "--names", "x", "y", "--length", "0.5", "--json"}));
  EXPECT_EQ(runs_, 1);
  EXPECT_EQ(values_.file, "a b");
  EXPECT_EQ(values_.many, 99'999'999'999);
  EXPECT_EQ(values_.names, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(values_.length_m, 0.5);
  EXPECT_TRUE(json_);  // an option of the program behind the command's name
  EXPECT_EQ(values_.text, "some");
  EXPECT_EQ(values_.count, 3);
  EXPECT_EQ(values_.size, 5U);
  EXPECT_FALSE(values_.flag);
  EXPECT_TRUE(values_.other);
  EXPECT_FALSE(count_->is_given());
}

TEST_F(CommandTest, ASecondValueAddsToAListOrIsRefused) {
  ASSERT_TRUE(parse({"draw", "--parts", "a,b", "f", "--parts", "c", "--level", "high"}));
  EXPECT_EQ(values_.parts, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(values_.file, "f");
  EXPECT_EQ(values_.levels, std::vector<std::string>{"high"});
  EXPECT_EQ(refusal({"draw", "f", "--level", "low", "--level", "high"}),
            "--level: found 2 values, allowed at most 1 (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--many", "1", "--many", "2"}),
            "--many: found 2 values, allowed at most 1 (program draw --help)");
}

TEST_F(CommandTest, FlagsSayYesOrNo) {
  ASSERT_TRUE(parse({"draw", "f", "--flag", "--no-other", "--count", "9", "--text", "other"}));
  EXPECT_TRUE(values_.flag);
  EXPECT_FALSE(values_.other);
  EXPECT_TRUE(count_->is_given());
  EXPECT_EQ(values_.count, 9);
  EXPECT_EQ(values_.text, "other");
}

TEST_F(CommandTest, HelpTellsTypesRangesAndOnlyTheDefaultsAskedFor) {
  const std::string text = help({"draw", "--help"});
  for (const char* part : {"Usage: program draw [OPTIONS] FILE",
                           "FILE TEXT REQUIRED",
                           "--text TEXT:{some,other}=some",
                           "--count INT:INT in [1 - 9] ",
                           "=4",
                           "--size UINT ",
                           "--length FLOAT:POSITIVE=0.25",
                           "--names TEXT ..."}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in\n" << text;
  }
  EXPECT_EQ(text.find("=3"), std::string::npos) << text;
  EXPECT_EQ(help({"--version"}), "program 1.2\n");
  EXPECT_EQ(runs_, 0);
}

TEST_F(CommandTest, HelpIsWrappedAndAnswersToItsName) {
  const std::string text = help({"draw", "--help"});
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120U) << line;
  EXPECT_EQ(help({"help", "draw"}), text);
  EXPECT_EQ(help({"help"}), help({"--help"}));
  EXPECT_EQ(help({"version"}), "program 1.2\n");
  EXPECT_EQ(help({"-v"}), "program 1.2\n");
}

TEST_F(CommandTest, RefusalsNameTheOptionAndWhatIsAllowed) {
  EXPECT_EQ(refusal({"draw"}), "FILE is required (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--count", "10"}),
            "--count: found 10, allowed 1 to 9 (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--text", "wrong"}),
            "--text: found wrong, allowed some, other (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--length", "0"}),
            "--length: found 0, allowed a number above 0 (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--length", "x"}),
            "--length: found x, allowed a number above 0 (program draw --help)");
  for (const std::string text : {"nan", "inf", "-inf", "1e999"}) {
    EXPECT_EQ(refusal({"draw", "f", "--length", text.c_str()}),
              "--length: found " + text + ", allowed a finite number (program draw --help)");
  }
  EXPECT_EQ(refusal({"draw", "f", "--size", "-1"}),
            "--size: found -1, allowed a whole number from 0 on (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "--size", "18446744073709551616"}),
            "--size: found 18446744073709551616, allowed 0 to 18446744073709551615 (program draw --help)");
  EXPECT_EQ(
      refusal({"draw", "f", "--stamp", "99999999999999999999"}),
      "--stamp: found 99999999999999999999, allowed -9223372036854775808 to 9223372036854775807 (program "
      "draw --help)");
  EXPECT_EQ(refusal({}), "found no command, allowed draw, far (program --help)");
  EXPECT_EQ(runs_, 0);
}

TEST_F(CommandTest, UnknownWordsAreAnsweredWithTheNearest) {
  EXPECT_EQ(refusal({"fly"}), "found \"fly\", allowed draw, far (program --help)");
  EXPECT_EQ(refusal({"darw", "f"}), "found \"darw\", did you mean draw? allowed draw, far (program --help)");
  EXPECT_EQ(
      refusal({"draw", "f", "--cuont=3"}),
      "found option \"--cuont\", did you mean --count? allowed those of program draw (program draw --help)");
  EXPECT_EQ(refusal({"draw", "--devise", "x"}),  // an option of the program, before FILE is missed
            "found option \"--devise\", did you mean --device? allowed those of program draw (program draw "
            "--help)");
  EXPECT_EQ(refusal({"draw", "f", "--xyzzy"}),
            "found option \"--xyzzy\", allowed those of program draw (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "-p"}),  // -h is an option of both
            "found option \"-p\", did you mean -h, -v? allowed those of program draw (program draw --help)");
  EXPECT_EQ(refusal({"draw", "f", "g"}), "found \"g\", allowed no further value (program draw --help)");
  EXPECT_EQ(runs_, 0);
}

TEST_F(CommandTest, HelpOfACommandHasTheProgramsOptions) {
  const std::string text = help({"draw", "--help"});
  const std::size_t shared = text.find("Options of every command:");
  ASSERT_NE(shared, std::string::npos) << text;
  EXPECT_NE(text.find("--json", shared), std::string::npos) << text;
  EXPECT_NE(text.find("part of its name", shared), std::string::npos) << text;
  EXPECT_EQ(text.find("--version"), std::string::npos) << text;
  EXPECT_EQ(help({"--help"}).find("Options of every command"), std::string::npos);
}

TEST_F(CommandTest, AnswersNeedNothingElse) {
  EXPECT_FALSE(parse({"draw", "--names", "one", "help", "--json"}));  // without FILE
  EXPECT_TRUE(json_);
  EXPECT_EQ(answers_, 1);
  EXPECT_EQ(runs_, 0);
  EXPECT_TRUE(parse({"draw", "picture", "--names", "one", "helpful"}));
  EXPECT_EQ(answers_, 1);
  EXPECT_EQ(runs_, 1);
}

TEST_F(CommandTest, ForeignCommandsGetAllArgumentsButTheirName) {
  ASSERT_TRUE(parse({"--device", "far", "--json", "far", "--help", "draw", "--", "far"}));
  EXPECT_EQ(foreign_, (std::vector<std::string>{"--device", "far", "--json", "--help", "draw", "--", "far"}));
  EXPECT_EQ(runs_, 1);
  ASSERT_TRUE(parse({"draw", "far"}));  // a value of another command
  EXPECT_EQ(runs_, 2);
  EXPECT_EQ(values_.file, "far");
}

TEST(Edits, NamesOfActorsMayHoldColons) {
  SceneFile file;
  const std::vector<KeyPose> track{{0.0, Pose()}, {1.0, Pose()}};
  for (const char* name : {"a", "a:b"}) file.scene.actors.push_back({name, "car", {4.0, 2.0, 1.5}, track});
  Edits edits;
  edits.move = {"a:b:1,0,0"};
  edits.retime = {"a:b:2", "a:2:0.5"};
  edits.classes = {"a:b:truck"};
  edits.duplicate = {"a:b:c"};
  EXPECT_EQ(copies_of(edits).at("c"), "a:b");
  apply(edits, file);
  const std::vector<Actor>& actors = file.scene.actors;
  ASSERT_EQ(actors.size(), 3U);
  EXPECT_EQ(actors[2].name, "c");
  EXPECT_EQ(actors[0].at(0.0).translation.x(), 0.0);
  EXPECT_EQ(actors[1].at(0.0).translation.x(), 1.0);
  EXPECT_EQ(actors[1].track.back().time_s, 0.5);
  EXPECT_EQ(actors[0].track.front().time_s, 0.5);
  EXPECT_EQ(actors[1].kind, "truck");
  edits = {};
  edits.move = {"a:c:1,0,0"};
  expect_error(ErrorKind::kUsage, "a:c", [&] { apply(edits, file); });
}

TEST(CrashDeathTest, WantOfMemoryInAThreadIsNoCrash) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "not run: crashes, AddressSanitizer tells of them itself";
#endif
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto run = [] {
    watch_crashes();
    std::thread([] { throw std::bad_alloc(); }).join();
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(kMemoryExit), "^simuli: out of memory\n$");
}

}  // namespace
}  // namespace simuli::cli
