#pragma once
// Checks the result of an import without an output.
#include <filesystem>
#include <gtest/gtest.h>

#include "io/log/log.hpp"

namespace simuli::test {

/// Expects the frames of `log` with its names and times, and no files.
inline void expect_survey(const Log& survey, const Log& log) {
  ASSERT_EQ(survey.images.size(), log.images.size());
  ASSERT_EQ(survey.sweeps.size(), log.sweeps.size());
  const auto expect_same = [](const auto& a, const auto& b) {
    EXPECT_EQ(a.file, b.file);
    EXPECT_NEAR(a.time_start_s, b.time_start_s, 1e-6);  // times of a log are whole nanoseconds
    EXPECT_NEAR(a.time_end_s, b.time_end_s, 1e-6);
  };
  for (std::size_t i = 0; i < log.images.size(); ++i) expect_same(survey.images[i], log.images[i]);
  for (std::size_t i = 0; i < log.sweeps.size(); ++i) expect_same(survey.sweeps[i], log.sweeps[i]);
  EXPECT_EQ(survey.cameras.size(), log.cameras.size());
  EXPECT_EQ(survey.lidars.size(), log.lidars.size());
  EXPECT_EQ(survey.actors.size(), log.actors.size());
  EXPECT_EQ(survey.masks.size(), log.masks.size());
  EXPECT_EQ(survey.world_from_rig.poses().size(), log.world_from_rig.poses().size());
  for (const char* kind : {"images", "sweeps", "masks", "points.ply"})
    EXPECT_FALSE(std::filesystem::exists(survey.folder / kind)) << kind;
}

}  // namespace simuli::test
