#include "host/apps/cli/base/progress.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>

namespace simuli {
namespace {

class ProgressTest : public testing::Test {
 protected:
  Progress make(ProgressStyle style, std::uint64_t total, int columns = 110) {
    return Progress(
        "train", total, style, out_, [this] { return now_s_; }, columns);
  }
  std::string take() {
    const std::string text = out_.str();
    out_.str("");
    return text;
  }
  std::ostringstream out_;
  double now_s_ = 1000.0;
};

TEST_F(ProgressTest, LinesComeEveryTenSecondsAndAtTheEnd) {
  Progress progress = make(ProgressStyle::kLines, 100);
  for (std::uint64_t i = 1; i <= 9; ++i) {
    now_s_ += 1.0;
    progress.update(i);
  }
  EXPECT_EQ(take(), "");
  now_s_ += 1.0;
  progress.update(10, "PSNR 21.3 dB");
  EXPECT_EQ(take(), "train  10 % 10/100  1:30 left  PSNR 21.3 dB\n");
  now_s_ += 5.0;
  progress.update(99);
  EXPECT_EQ(take(), "");
  progress.update(100);
  progress.finish("PSNR 25.0 dB");
  EXPECT_EQ(take(), "train 100 % 100/100  0:15 elapsed  PSNR 25.0 dB\n");
  progress.update(100);
  progress.finish();
  EXPECT_EQ(take(), "");
}

TEST_F(ProgressTest, TheTimeLeftIsOfTheStepsSinceTheStart) {
  Progress progress = make(ProgressStyle::kLines, 1000);
  now_s_ += 60.0;  // a first step that compiles, of a training that goes on at 500
  progress.start_at(501);
  now_s_ += 10.0;
  progress.update(526);
  EXPECT_EQ(take(), "train  52 % 526/1000  3:10 left\n");
  progress.update(1000);
  progress.finish();
  EXPECT_EQ(take(), "train 100 % 1000/1000  0:10 elapsed\n");
}

TEST_F(ProgressTest, BarIsRedrawnInPlaceAtMostTenTimesASecond) {
  {
    Progress progress = make(ProgressStyle::kBar, 4);
    now_s_ += 0.01;
    progress.update(1);
    EXPECT_EQ(take(), "\rtrain [######..................]  25 % 1/4  0:00 elapsed\x1b[K");
    now_s_ += 0.05;
    progress.update(2);
    EXPECT_EQ(take(), "");
    now_s_ += 59.94;
    progress.update(3);
    EXPECT_EQ(take(), "\rtrain [##################......]  75 % 3/4  0:20 left\x1b[K");
  }
  EXPECT_EQ(take(), "\n");  // broken off: the next message starts on its own line
}

TEST_F(ProgressTest, FinishedBarEndsItsLine) {
  {
    Progress progress = make(ProgressStyle::kBar, 4);
    progress.update(4);
    take();
    progress.finish();
    EXPECT_EQ(take(), "\rtrain [########################] 100 % 4/4  0:00 elapsed\x1b[K\n");
  }
  EXPECT_EQ(take(), "");
}

TEST_F(ProgressTest, BarFitsTheTerminal) {
  Progress progress = make(ProgressStyle::kBar, 4, 30);
  progress.update(1, "a text that is much too long for it");
  const std::string text = take();
  EXPECT_EQ(text.size(), std::string("\r").size() + 29 + std::string("\x1b[K").size());
}

/// A narrow terminal shows whole notes or none.
TEST_F(ProgressTest, NotesAreLeftOutWhole) {
  Progress progress = make(ProgressStyle::kBar, 4, 80);
  progress.update(1, "PSNR 18.69 dB  mean distance error 13.7 cm  drop 95.4 %");
  EXPECT_EQ(take(), "\rtrain [######..................]  25 % 1/4  0:00 elapsed  PSNR 18.69 dB\x1b[K");
}

/// The first file of a start took as long as all others: it told of hours (see kTellingShare).
TEST_F(ProgressTest, NoTimeIsLeftBeforeItCanBeKnown) {
  struct Case {
    std::uint64_t done, total;
    double elapsed_s;
    const char* reported;
  };
  for (const Case& c : {Case{1, 216, 26.0, "  0:26 elapsed"},
                        Case{10, 216, 30.0, "  0:30 elapsed"},
                        Case{11, 216, 30.0, "  9:19 left"},
                        Case{1, 2, 20.0, "  0:20 elapsed"},
                        Case{0, 8, 20.0, "  0:20 elapsed"},
                        Case{2, 4, 10.0, "  0:10 left"},
                        Case{1, 1, 10.0, "train  0:10 elapsed"}}) {
    Progress progress = make(ProgressStyle::kLines, c.total);
    now_s_ += c.elapsed_s;
    progress.update(c.done);
    EXPECT_NE(take().find(c.reported), std::string::npos) << c.done << '/' << c.total;
  }
  Progress json = make(ProgressStyle::kJson, 216);
  now_s_ += 26.0;
  json.update(1);
  EXPECT_NE(take().find(R"("left_s":null)"), std::string::npos);
}

TEST_F(ProgressTest, WhatIsDoneNeverGetsLess) {
  Progress progress = make(ProgressStyle::kLines, 100);
  progress.update(60);
  now_s_ += 10.0;
  progress.update(4);
  EXPECT_EQ(take(), "train  60 % 60/100  0:07 left\n");
  progress.complete();  // it ended early
  EXPECT_EQ(take(), "train 100 % 100/100  0:10 elapsed\n");
}

TEST_F(ProgressTest, QuietWritesNothing) {
  {
    Progress progress = make(ProgressStyle::kQuiet, 4);
    now_s_ += 100.0;
    progress.update(2);
    progress.finish();
  }
  EXPECT_EQ(take(), "");
}

TEST_F(ProgressTest, JsonIsOneObjectALineOnceASecond) {
  Progress progress = make(ProgressStyle::kJson, 4);
  progress.update(0);
  EXPECT_EQ(take(),
            R"({"task":"train","done":0,"total":4,"elapsed_s":0.0,"left_s":null,"finished":false})"
            "\n");
  now_s_ += 0.5;
  progress.update(1);
  EXPECT_EQ(take(), "");
  now_s_ += 1.5;
  progress.update(2, {"said to people", {{"psnr_db", 21.25}, {"distance_m", std::nan("")}}});
  EXPECT_EQ(take(),
            R"({"task":"train","done":2,"total":4,"elapsed_s":2.0,"left_s":2.0,"finished":false,)"
            R"("psnr_db":21.25,"distance_m":null})"
            "\n");
  progress.finish();
  EXPECT_NE(take().find(R"("left_s":0.0,"finished":true)"), std::string::npos);
}

TEST_F(ProgressTest, UnknownAndImpossibleSizesAreShownAsTheyAre) {
  Progress unknown = make(ProgressStyle::kLines, 0);
  now_s_ += 12.0;
  unknown.update(7);
  EXPECT_EQ(take(), "train 7  0:12 elapsed\n");
  Progress nothing_done = make(ProgressStyle::kLines, 10);
  now_s_ += 10.0;
  nothing_done.update(0);
  EXPECT_EQ(take(), "train   0 % 0/10  0:10 elapsed\n");
  Progress almost = make(ProgressStyle::kLines, 1000);
  now_s_ += 10.0;
  almost.update(999);
  EXPECT_EQ(take().substr(0, 12), "train  99 % ");  // 99.9 %: not done
}

TEST(FormatDuration, Rounds) {
  EXPECT_EQ(format_duration(0.4), "0:00");
  EXPECT_EQ(format_duration(59.6), "1:00");
  EXPECT_EQ(format_duration(754.0), "12:34");
  EXPECT_EQ(format_duration(3723.0), "1:02:03");
  EXPECT_EQ(format_duration(-1.0), "--:--");
  EXPECT_EQ(format_duration(std::numeric_limits<double>::quiet_NaN()), "--:--");
  EXPECT_EQ(format_duration(std::numeric_limits<double>::infinity()), "--:--");
}

}  // namespace
}  // namespace simuli
