#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <thread>

#include "host/apps/serve/session/refusal.hpp"
#include "host/apps/serve/session/render_session.hpp"
#include "io/base/file.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/ascii_ply.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;
using Session = test::Served;

TEST(FairQueue, AreTakenInOrder) {
  const FairQueue turns(1);
  std::vector<int> order;
  std::vector<std::jthread> callers;
  {
    const FairQueue::Ticket first = turns.take();
    for (int i = 0; i < 5; ++i) {
      callers.emplace_back([&, i] {
        const FairQueue::Ticket turn = turns.take();
        order.push_back(i);
      });
      std::this_thread::sleep_for(std::chrono::milliseconds(30));  // until it stands in line
    }
    EXPECT_TRUE(order.empty());
  }
  callers.clear();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(FairQueue, WhoGivesUpLeavesTheLine) {
  const FairQueue turns(2);
  std::optional<FairQueue::Ticket> one = turns.take();
  const FairQueue::Ticket two = turns.take();
  std::atomic<bool> is_given_up = false;
  std::jthread waiting([&] {
    expect_refusal(RefusalKind::kCancelled, "cancelled", [&] {
      static_cast<void>(turns.take([&] { return is_given_up.load(); }));
    });
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  is_given_up = true;
  waiting.join();
  one.reset();
  static_cast<void>(turns.take());
}

TEST(FairQueue, PlacesAreHadByOneAtATime) {
  const FairQueue turns(3);
  std::array<std::atomic<int>, 3> users{};
  std::atomic<bool> is_shared = false;
  {
    std::vector<std::jthread> callers;
    for (int i = 0; i < 8; ++i) {
      callers.emplace_back([&] {
        for (int round = 0; round < 50; ++round) {
          const FairQueue::Ticket turn = turns.take();
          if (++users.at(turn.place()) > 1) is_shared = true;
          std::this_thread::yield();
          --users.at(turn.place());
        }
      });
    }
  }
  EXPECT_FALSE(is_shared);
  EXPECT_EQ(turns.free(), 3U);
  EXPECT_EQ(turns.take().place(), 0U);
}

TEST(SceneSources, AreNamed) {
  const auto sources =
      scene_sources({"a/drive.scene/", "b/street.scene", "night=b/drive.scene", "./x=y/z.ply"});
  ASSERT_EQ(sources.size(), 4U);
  EXPECT_EQ(sources[0].id, "drive");
  EXPECT_EQ(sources[1].id, "street");
  EXPECT_EQ(sources[2].id, "night");
  EXPECT_EQ(sources[2].path, "b/drive.scene");
  EXPECT_EQ(sources[3].id, "z");
  expect_error(ErrorKind::kUsage, "two named \"drive\"", [] {
    static_cast<void>(scene_sources({"a/drive.scene", "b/drive.scene"}));
  });
  expect_error(ErrorKind::kUsage, "SCENE", [] { static_cast<void>(scene_sources({"=x"})); });
  expect_error(ErrorKind::kUsage, "SCENE", [] { static_cast<void>(scene_sources({})); });
}

TEST_F(Session, KeepsTheScenesUsedLast) {
  const std::string path = (scratch_ / "small.scene").string();
  SessionOptions options;
  options.scenes = scene_sources({"a=" + path, "b=" + path, "c=" + path});
  options.cache_size = 2;
  RenderSession session(options);
  EXPECT_TRUE(session.kept().empty());
  auto a = session.open("a");
  EXPECT_EQ(session.open("a"), a);  // once
  static_cast<void>(session.open("b"));
  EXPECT_EQ(session.kept(), (std::vector<std::string>{"b", "a"}));
  static_cast<void>(session.open("a"));
  static_cast<void>(session.open("c"));
  EXPECT_EQ(session.kept(), (std::vector<std::string>{"c", "a"}));
  static_cast<void>(session.open("b"));
  EXPECT_EQ(session.kept(), (std::vector<std::string>{"b", "c"}));
  // Who holds one renders it still.
  std::size_t pixels = 0;
  std::array<FrameJob, 1> job{FrameJob{a->cameras()[0],
                                       recorded_shot("front", 0.5, 0.5),
                                       [&](const Frame& frame) { pixels = frame.results().rays; }}};
  session.render(*a, job);
  EXPECT_EQ(pixels, 48U * 32U);
  EXPECT_NE(session.open("a"), a);
}

TEST_F(Session, GivesMemoryBackWithAScene) {
  const std::string path = (scratch_ / "small.scene").string();
  SessionOptions options;
  options.scenes = scene_sources({"a=" + path, "b=" + path});
  options.cache_size = 1;
  RenderSession session(options);
  std::uint64_t most = 0;
  for (int round = 0; round < 6; ++round) {
    const auto scene = session.open(round % 2 == 0 ? "a" : "b");
    std::array<FrameJob, 1> job{
        FrameJob{scene->cameras()[0], recorded_shot("front", 0.5, 0.5), [](const Frame& f) { f.wait(); }}};
    session.render(*scene, job);
    if (round == 1) most = session.device().memory().now;
  }
  EXPECT_LE(session.device().memory().now, most);
}

TEST_F(Session, SeveralDevicesShareABatch) {
  const std::string path = (scratch_ / "small.scene").string();
  constexpr std::size_t kFrames = 12;
  const auto rendered = [&](std::size_t devices) {
    SessionOptions options;
    options.scenes = scene_sources({"a=" + path});
    options.devices.assign(devices, "");
    RenderSession session(options);
    const auto scene = session.open("a");
    std::vector<FrameJob> jobs;
    for (std::size_t i = 0; i < kFrames; ++i) {
      const double time_s = 0.5 + 0.01 * static_cast<double>(i);
      jobs.push_back({scene->cameras()[0], recorded_shot("front", time_s, time_s)});
    }
    session.render(*scene, jobs);
    // By others than the first as well, sooner or later.
    std::atomic<bool> is_done = false;
    std::vector<std::jthread> callers;
    for (std::size_t k = 1; k < devices; ++k) {
      callers.emplace_back([&] {
        while (!is_done) {
          std::array<FrameJob, 1> job{FrameJob{scene->cameras()[0], recorded_shot("front", 0.5, 0.5)}};
          session.render(*scene, job);
          EXPECT_FALSE(job[0].bytes.empty());
        }
      });
    }
    for (std::size_t k = 1; k < devices; ++k) {
      while (session.device(k).memory().peak == 0) {
        std::array<FrameJob, 1> job{FrameJob{scene->cameras()[0], recorded_shot("front", 0.5, 0.5)}};
        session.render(*scene, job);
      }
    }
    is_done = true;
    callers.clear();
    std::vector<std::string> bytes;
    for (FrameJob& job : jobs) {
      EXPECT_EQ(job.error, nullptr);
      bytes.push_back(std::move(job.bytes));
    }
    return bytes;
  };
  const std::vector<std::string> one = rendered(1), three = rendered(3);
  EXPECT_EQ(three, one);
  EXPECT_NE(one.front(), one.back());
}

TEST_F(Session, GivenUpOnSeveralDevicesEndsOnAll) {
  SessionOptions options;
  options.scenes = scene_sources({"a=" + (scratch_ / "small.scene").string()});
  options.devices = {"", ""};
  RenderSession session(options);
  const auto scene = session.open("a");
  std::atomic<int> frames = 0;
  std::vector<FrameJob> jobs;
  for (std::size_t i = 0; i < 50; ++i) {
    jobs.push_back({scene->cameras()[0], recorded_shot("front", 0.5, 0.5), [&](const Frame& f) {
                      f.wait();
                      ++frames;
                    }});
  }
  expect_refusal(RefusalKind::kCancelled, "cancelled", [&] {
    session.render(*scene, jobs, [&] { return frames > 4; });
  });
  EXPECT_LT(frames, 12);
}

TEST_F(Session, TellsOfBrokenSplats) {
  write_file_atomically(scratch_ / "a.ply", test::half_broken_ply());
  SessionOptions some = options();
  some.scenes = scene_sources({(scratch_ / "a.ply").string()});
  std::vector<std::string> reported;
  some.note = [&](const std::string& text) { reported.push_back(text); };
  EXPECT_EQ(RenderSession(some).open("a")->scene().camera.size(), 1);
  EXPECT_EQ(reported, std::vector<std::string>{"a: left out: " + broken_particles(1)});
}

TEST_F(Session, TellsOfScenesThatAreNone) {
  SessionOptions options;
  options.scenes = scene_sources({(scratch_ / "nowhere.scene").string()});
  RenderSession session(options);
  for (int again = 0; again < 2; ++again) {
    expect_refusal(
        RefusalKind::kPrecondition, "nowhere.scene", [&] { static_cast<void>(session.open("nowhere")); });
  }
  EXPECT_TRUE(session.kept().empty());
  expect_error(ErrorKind::kInput, "nowhere.scene", [&] { session.read_now("nowhere"); });
  // It may come to be there.
  std::filesystem::rename(scratch_ / "small.scene", scratch_ / "nowhere.scene");
  EXPECT_EQ(session.open("nowhere")->id(), "nowhere");
}

TEST_F(Session, AFrameThatFailsLeavesTheOthers) {
  std::array<int, 3> rendered{};
  std::vector<FrameJob> jobs;
  for (std::size_t i = 0; i < 3; ++i) {
    jobs.push_back({scene_->cameras()[0], recorded_shot("front", 0.5, 0.5), [&rendered, i](const Frame&) {
                      rendered[i] = 1;
                    }});
  }
  jobs[1].shot.edits = {{"nobody", ActorEdit::Remove{}}};
  session_->render(*scene_, jobs);
  EXPECT_EQ(rendered, (std::array<int, 3>{1, 0, 1}));
  ASSERT_TRUE(jobs[1].error);
  EXPECT_EQ(static_cast<int>(refusal_of(jobs[1].error).kind()), static_cast<int>(RefusalKind::kInvalid));
}

TEST(Refusal, IsOneShortLine) {
  const Refusal refusal(RefusalKind::kInvalid, "a\nb" + std::string(999, 'x') + std::string(600, '\xC3'));
  EXPECT_LE(std::string(refusal.what()).size(), 1010U);
  EXPECT_EQ(std::string(refusal.what()).find('\n'), std::string::npos);
  std::string accents;
  for (int i = 0; i < 600; ++i) accents += "\xC3\xA9";
  const std::string reported = Refusal(RefusalKind::kInvalid, "x" + accents).what();
  EXPECT_EQ(reported.substr(reported.size() - 5, 2), "\xC3\xA9");  // whole
}

}  // namespace
}  // namespace simuli::serve
