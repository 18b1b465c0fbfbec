// Tests caching and read-ahead of the frames of a log.
#include "io/log/frame_files.hpp"

#include <atomic>
#include <chrono>
#include <functional>
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "host/core/sensors/lidar.hpp"
#include "io/synth/street.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::Scratch;

constexpr std::size_t kPixels = 100, kFrameBytes = kPixels * sizeof(float);

/// A frame of one number that counts its reads.
class Numbered {
 public:
  FrameFiles::Wish wish(int number) {
    return {std::to_string(number), [this, number] {
              ++made;
              if (number == failing) throw Error(ErrorKind::kInput, "unreadable");
              Image image(static_cast<int>(kPixels), 1, 1);
              image.data.assign(kPixels, static_cast<float>(number));
              return FrameFiles::Frame(std::move(image));
            }};
  }
  std::vector<FrameFiles::Wish> wishes(int first, int end) {
    std::vector<FrameFiles::Wish> out;
    for (int i = first; i < end; ++i) out.push_back(wish(i));
    return out;
  }
  std::atomic<int> made = 0, failing = -1;
};

float number_of(const std::shared_ptr<const FrameFiles::Frame>& frame) {
  return std::get<Image>(*frame).data.back();
}

/// Whether the condition becomes true within a minute.
template <class F>
bool comes_to(const F& is_so) {
  for (int i = 0; i < 6000 && !is_so(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return is_so();
}

TEST(FrameFiles, WhatWasReadIsKeptWithinTheBudget) {
  Numbered numbered;
  FrameFiles files(3 * kFrameBytes);
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(number_of(files.get(numbered.wish(i))), static_cast<float>(i));
  }
  EXPECT_EQ(numbered.made, 3);
  EXPECT_EQ(files.kept_bytes(), 3 * kFrameBytes);
  EXPECT_EQ(number_of(files.get(numbered.wish(3))), 3.0F);  // in place of the oldest
  EXPECT_EQ(number_of(files.get(numbered.wish(2))), 2.0F);
  EXPECT_EQ(numbered.made, 4);
  EXPECT_EQ(number_of(files.get(numbered.wish(0))), 0.0F);
  EXPECT_EQ(numbered.made, 5);
  EXPECT_EQ(files.reads(), 5U);
}

TEST(FrameFiles, AnInterruptionIsHeardBetweenThem) {
  Numbered numbered;
  FrameFiles files(3 * kFrameBytes);
  (void)files.get(numbered.wish(0));
  {
    const std::function<void()> check = [] { throw std::runtime_error("interrupted"); };
    const Interruption interruption(check);
    for (int i = 0; i < 2; ++i) EXPECT_THROW((void)files.get(numbered.wish(i)), std::runtime_error) << i;
  }
  EXPECT_EQ(numbered.made, 1);
  EXPECT_EQ(number_of(files.get(numbered.wish(1))), 1.0F);
}

TEST(FrameFiles, WhatIsExpectedIsReadAheadAndNoFarther) {
  Numbered numbered;
  FrameFiles files(0);  // no cache: each frame is still read once
  files.expect(numbered.wishes(0, 50));
  ASSERT_TRUE(comes_to([&] { return numbered.made == 4; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(numbered.made, 4);
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(number_of(files.get(numbered.wish(i))), static_cast<float>(i));
    ASSERT_LE(numbered.made, i + 6);
  }
  EXPECT_EQ(numbered.made, 50);
  EXPECT_EQ(files.kept_bytes(), 0U);
}

TEST(FrameFiles, WhatIsKeptIsNotReadAhead) {
  Numbered numbered;
  FrameFiles files(10 * kFrameBytes);
  for (int i = 0; i < 5; ++i) (void)files.get(numbered.wish(i));
  files.expect(numbered.wishes(0, 7));
  ASSERT_TRUE(comes_to([&] { return numbered.made == 7; }));
  files.expect(numbered.wishes(5, 7));  // already read ahead
  for (int i = 6; i >= 0; --i) EXPECT_EQ(number_of(files.get(numbered.wish(i))), static_cast<float>(i));
  EXPECT_EQ(numbered.made, 7);
}

TEST(FrameFiles, OneThatCannotBeReadIsItsReaders) {
  Numbered numbered;
  numbered.failing = 1;
  FrameFiles files(10 * kFrameBytes);
  files.expect(numbered.wishes(0, 3));
  EXPECT_EQ(number_of(files.get(numbered.wish(0))), 0.0F);
  EXPECT_THROW((void)files.get(numbered.wish(1)), Error);
  EXPECT_THROW((void)files.get(numbered.wish(1)), Error);
  EXPECT_EQ(number_of(files.get(numbered.wish(2))), 2.0F);
  numbered.failing = -1;
  EXPECT_EQ(number_of(files.get(numbered.wish(1))), 1.0F);
}

TEST(FrameFiles, EndsWithFramesUnderWay) {
  Numbered numbered;
  for (int i = 0; i < 50; ++i) {
    FrameFiles files(2 * kFrameBytes);
    files.expect(numbered.wishes(0, 20));
    if (i % 2 == 0) (void)files.get(numbered.wish(i % 20));
  }
  EXPECT_GT(numbered.made, 0);
}

TEST(FrameFiles, SweepsAreThoseOfTheirFiles) {
  const Scratch scratch;
  StreetOptions options;
  options.output = scratch / "street.log";
  options.frames = 2;
  options.image_width = 64;
  options.image_height = 36;
  options.lidar_columns = 90;
  Log log = synth_street(options);
  Lidar biased = log.lidars.front().with_rows();
  for (LidarRow& row : biased.rows) row.range_bias = 0.25;
  const SweepFrame& frame = log.sweeps.back();
  const std::filesystem::path file = log.folder / frame.file;
  const auto same = [&](const LidarModel& lidar) {
    const Sweep wanted = read_sweep(file, lidar), found = read_sweep(log, frame, lidar);
    EXPECT_EQ(found.range, wanted.range);
    EXPECT_EQ(found.intensity, wanted.intensity);
    EXPECT_EQ(found.rays.azimuth, wanted.rays.azimuth);
    EXPECT_EQ(found.rays.elevation, wanted.rays.elevation);
    EXPECT_EQ(found.rays.time_fraction, wanted.rays.time_fraction);
    return found.range;
  };
  const std::vector<float> alone = same(biased);
  log.files = std::make_shared<FrameFiles>(std::size_t{1} << 20U);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(same(biased), alone);  // biases are removed once per read
    EXPECT_NE(same(log.lidars.front().model), alone);
  }
  EXPECT_EQ(log.files->reads(), 1U);
  expect(log, {&log.sweeps.front(), &frame});
  EXPECT_TRUE(comes_to([&] { return log.files->reads() == 2; }));
}

}  // namespace
}  // namespace simuli
