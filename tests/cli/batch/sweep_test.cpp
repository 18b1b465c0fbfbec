// Files of jobs from --vary.
#include "host/cli/batch/sweep.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

using Words = std::vector<std::string>;

const Words kRender{"render", "s.scene", "-o", "out/{}"};

std::vector<SweepJob> sweep_of(const Words& texts, const Words& words = kRender) {
  std::vector<Variation> variations;
  for (const std::string& text : texts) variations.push_back(parse_variation(text));
  return sweep(variations, words);
}

/// What is added to the words.
Words added(const std::string& text) {
  const Words words = sweep_of({text}).front().words;
  return {words.begin() + static_cast<std::ptrdiff_t>(kRender.size()), words.end()};
}

void expect_refused(const Words& texts, const std::string& part, const Words& words = kRender) {
  try {
    static_cast<void>(sweep_of(texts, words));
    FAIL() << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Sweep, RangesIncludeTheirEndsAndReadAsWritten) {
  EXPECT_EQ(parse_variation("a=-1:1:0.5").values, (Words{"-1", "-0.5", "0", "0.5", "1"}));
  EXPECT_EQ(parse_variation("a=0:0.3:0.1").values, (Words{"0", "0.1", "0.2", "0.3"}));
  EXPECT_EQ(parse_variation("a=1:0:-0.5").values, (Words{"1", "0.5", "0"}));
  EXPECT_EQ(parse_variation("a=2:2:1").values, (Words{"2"}));
  EXPECT_EQ(parse_variation("a=0,1.5,3").values, (Words{"0", "1.5", "3"}));
  EXPECT_EQ(parse_variation("sensor=front,left").values, (Words{"front", "left"}));
  // Three parts that are no numbers are a value: --track's LOG:ACTOR.
  EXPECT_EQ(parse_variation("car.track=a:b:c").values, (Words{"a:b:c"}));
}

TEST(Sweep, KeysAreTheCommandsOwnEdits) {
  EXPECT_EQ(added("car_0.move.left=-1"), (Words{"--move", "car_0:0,-1,0"}));
  EXPECT_EQ(added("car_0.turn=90"), (Words{"--turn", "car_0:90"}));
  EXPECT_EQ(added("car_0.resize=1.2"), (Words{"--resize", "car_0:1.2"}));
  EXPECT_EQ(added("car_0.retime.delay=2"), (Words{"--retime", "car_0:1:2"}));
  EXPECT_EQ(added("car_0.track=other.log"), (Words{"--track", "car_0:other.log"}));
  EXPECT_EQ(added("car_0.duplicate=car_1"), (Words{"--duplicate", "car_0:car_1"}));
  EXPECT_EQ(added("car_0.remove=1"), (Words{"--remove", "car_0"}));
  EXPECT_EQ(added("car_0.remove=0"), (Words{}));
  EXPECT_EQ(added("lane_shift=1.5"), (Words{"--lane-shift", "1.5"}));
  EXPECT_EQ(added("mount.z=2.1"), (Words{"--mount", "0,0,2.1,0,0,0"}));
  EXPECT_EQ(added("set.render.alpha=0.5"), (Words{"--set", "render.alpha=0.5"}));
  EXPECT_EQ(added("a.b.move.up=1"), (Words{"--move", "a.b:0,0,1"}));
}

TEST(Sweep, EveryValueWithEveryOther) {
  const std::vector<SweepJob> jobs = sweep_of({"car.move.left=0,1", "lane_shift=0,2", "car.move.forward=3"});
  ASSERT_EQ(jobs.size(), 4U);
  EXPECT_EQ(jobs[0].name, "car.move.left=0,lane_shift=0,car.move.forward=3");
  EXPECT_EQ(jobs[1].name, "car.move.left=0,lane_shift=2,car.move.forward=3");
  EXPECT_EQ(jobs[2].name, "car.move.left=1,lane_shift=0,car.move.forward=3");
  // One actor is moved once, by all that is said of it.
  EXPECT_EQ(jobs[3].words,
            (Words{"render",
                   "s.scene",
                   "-o",
                   "out/car.move.left=1,lane_shift=2,car.move.forward=3",
                   "--lane-shift",
                   "2",
                   "--move",
                   "car:3,1,0"}));
  const nlohmann::json read = nlohmann::json::parse(jobs_text(jobs));
  EXPECT_EQ(read.at("format"), "simuli batch");
  EXPECT_EQ(read.at("jobs").size(), 4U);
  EXPECT_EQ(read.at("jobs").at(3).at("run"), jobs[3].words);
}

TEST(Sweep, NamesAreNames) {
  EXPECT_EQ(sweep_of({"car.track=logs/a.log"}).front().name, "car.track=logs_a.log");
  EXPECT_EQ(sweep_of({"lane_shift=1"}, {"render", "s.scene", "-o", "{}/{}"}).front().words[3],
            "lane_shift=1/lane_shift=1");
}

TEST(Sweep, WhatSaysNothingIsRefused) {
  for (const char* text : {"", "a", "=1"}) expect_refused({text}, "allowed KEY=A,B,C or KEY=FIRST:LAST:STEP");
  expect_refused({"a="}, "a value between commas");
  expect_refused({"a=1,,2"}, "a value between commas");
  expect_refused({"a=1,2,1"}, "each value once");
  expect_refused({"a=0:1:0"}, "steps that lead from the first to the last");
  expect_refused({"a=0:1:-1"}, "steps that lead from the first to the last");
  expect_refused({"a=0:1:1e-9"}, "steps that lead from the first to the last");
  expect_refused({"a=0:1:0.001", "b=0:1:0.001"}, "at most a million jobs");
  expect_refused({"a=1", "a=2"}, "each key once");
  expect_refused({"car.move=1"}, "ACTOR.move.forward|left|up");
  expect_refused({"car.move.sideways=1"}, "forward, left, up at its end");
  expect_refused({"car.fly=1"}, "ACTOR.move.forward|left|up");
  expect_refused({"mount.w=1"}, "x, y, z, roll, pitch, yaw at its end");
  expect_refused({"car.remove=yes"}, "0 or 1");
  expect_refused({"lane_shift=1"}, "{} in its output's name", {"render", "s.scene", "-o", "out"});
}

}  // namespace
}  // namespace simuli::cli
