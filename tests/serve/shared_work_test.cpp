// Work that several ask for at once is done once.
#include "host/apps/serve/session/shared_work.hpp"

#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>
#include <vector>

#include "host/apps/serve/session/refusal.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using std::chrono::milliseconds;
using test::expect_refusal;

SharedWork::Result number(int value) { return std::make_shared<const int>(value); }
int value_of(const SharedWork::Result& result) { return *static_cast<const int*>(result.get()); }

/// Work that begins, and ends when it may.
struct Gate {
  std::atomic<int> begun = 0;
  std::atomic<bool> is_open = false;

  SharedWork::Work work(int value) {
    return [this, value](const IsGivenUp& is_given_up) {
      ++begun;
      while (!is_open) {
        throw_if_cancelled(is_given_up);
        std::this_thread::sleep_for(milliseconds(2));
      }
      return number(value);
    };
  }
  void wait_for(int count) const {
    while (begun < count) std::this_thread::sleep_for(milliseconds(2));
  }
};

/// Until those who have been started stand in line.
void settle() { std::this_thread::sleep_for(milliseconds(60)); }

TEST(SharedWork, IsDoneOnceForAllWhoAsk) {
  SharedWork shared;
  Gate gate;
  std::atomic<int> right = 0;
  {
    std::vector<std::jthread> callers;
    const auto ask = [&](const char* key, int value) {
      callers.emplace_back([&, key, value] {
        right += value_of(shared.get(key, gate.work(value), never_given_up)) == value ? 1 : 0;
      });
    };
    ask("a", 1);
    gate.wait_for(1);
    for (int k = 0; k < 5; ++k) ask("a", 1);
    ask("b", 2);
    gate.wait_for(2);
    settle();
    gate.is_open = true;
  }
  EXPECT_EQ(gate.begun, 2);
  EXPECT_EQ(right, 7);
  EXPECT_EQ(shared.shared(), 5U);
  // Nothing is kept.
  EXPECT_EQ(value_of(shared.get("a", gate.work(3), never_given_up)), 3);
  EXPECT_EQ(gate.begun, 3);
}

TEST(SharedWork, GoesOnWhileAnybodyWaits) {
  SharedWork shared;
  Gate gate;
  std::atomic<bool> first_left = false;
  std::atomic<int> found = 0;
  {
    std::jthread first([&] {
      // It does the work, and so stays, though nobody wants it of him.
      found += value_of(shared.get("a", gate.work(7), [&] { return first_left.load(); }));
    });
    gate.wait_for(1);
    std::jthread second([&] { found += value_of(shared.get("a", gate.work(0), never_given_up)); });
    settle();
    first_left = true;
    settle();
    EXPECT_EQ(found, 0);
    gate.is_open = true;
  }
  EXPECT_EQ(found, 14);
  EXPECT_EQ(gate.begun, 1);
}

TEST(SharedWork, EndsWhenNobodyDoes) {
  SharedWork shared;
  Gate gate;
  std::atomic<bool> have_left = false;
  const auto leave = [&] { return have_left.load(); };
  const auto cancelled = [&] {
    expect_refusal(RefusalKind::kCancelled, "cancelled", [&] {
      static_cast<void>(shared.get("a", gate.work(1), leave));
    });
  };
  {
    std::jthread first(cancelled);
    gate.wait_for(1);
    std::jthread second(cancelled);
    settle();
    have_left = true;
  }
  EXPECT_EQ(gate.begun, 1);
  gate.is_open = true;
  EXPECT_EQ(value_of(shared.get("a", gate.work(4), never_given_up)), 4);
}

TEST(SharedWork, WhoComesToWorkThatIsBeingEndedStartsItsOwn) {
  SharedWork shared;
  std::atomic<bool> has_left = false, may_end = false, is_ending = false;
  std::jthread first([&] {
    EXPECT_THROW(static_cast<void>(shared.get(
                     "a",
                     [&](const IsGivenUp& is_given_up) -> SharedWork::Result {
                       while (!is_given_up()) std::this_thread::sleep_for(milliseconds(2));
                       is_ending = true;
                       while (!may_end) std::this_thread::sleep_for(milliseconds(2));
                       throw Refusal(RefusalKind::kCancelled, "cancelled");
                     },
                     [&] { return has_left.load(); })),
                 Refusal);
  });
  has_left = true;
  while (!is_ending) std::this_thread::sleep_for(milliseconds(2));
  EXPECT_EQ(value_of(shared.get(
                "a", [](const IsGivenUp&) { return number(5); }, never_given_up)),
            5);
  may_end = true;
}

TEST(SharedWork, AllAreToldWhatWentWrong) {
  SharedWork shared;
  Gate gate;
  std::atomic<int> reported = 0;
  {
    std::vector<std::jthread> callers;
    for (int k = 0; k < 3; ++k) {
      callers.emplace_back([&] {
        try {
          static_cast<void>(shared.get(
              "a",
              [&](const IsGivenUp& is_given_up) -> SharedWork::Result {
                static_cast<void>(gate.work(0)(is_given_up));
                throw std::runtime_error("no room");
              },
              never_given_up));
        } catch (const std::runtime_error& error) {
          reported += std::string(error.what()) == "no room" ? 1 : 0;
        }
      });
    }
    gate.wait_for(1);
    settle();
    gate.is_open = true;
  }
  EXPECT_EQ(reported, 3);
  EXPECT_EQ(gate.begun, 1);
}

}  // namespace
}  // namespace simuli::serve
