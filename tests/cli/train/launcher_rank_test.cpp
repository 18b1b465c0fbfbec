// Which rank a process is, as launchers say it.
#include <gtest/gtest.h>
#include <map>
#include <string>

#include "host/apps/cli/train/launched_ranks.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

using Variables = std::map<std::string, std::string>;

Environment of(const Variables& variables) {
  return [variables = std::make_shared<Variables>(variables)](const char* name) -> const char* {
    const auto at = variables->find(name);
    return at == variables->end() ? nullptr : at->second.c_str();
  };
}

void expect_rank(const Variables& variables, std::size_t index, std::size_t count) {
  const LauncherRank rank = rank_in(of(variables));
  EXPECT_EQ(rank.index, index);
  EXPECT_EQ(rank.count, count);
}

void expect_refused(const Variables& variables, const std::string& part) {
  try {
    static_cast<void>(rank_in(of(variables)));
    FAIL() << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(LauncherRank, EveryLauncherIsUnderstood) {
  expect_rank({}, 0, 1);
  expect_rank({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 2, 4);
  expect_rank({{"PMI_RANK", "1"}, {"PMI_SIZE", "3"}}, 1, 3);
  expect_rank({{"PMIX_RANK", "5"}, {"SLURM_NTASKS", "8"}}, 5, 8);
  // OpenMPI says both, and the size in its own words alone.
  expect_rank({{"PMIX_RANK", "3"}, {"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 3, 4);
  // A batch script outside of any step has the number of tasks, too, and is one process.
  expect_rank({{"SLURM_NTASKS", "8"}, {"SLURM_PROCID", "0"}}, 0, 1);
}

TEST(LauncherRank, WhatDoesNotFitIsRefused) {
  expect_refused({{"PMIX_RANK", "1"}}, "SLURM_NTASKS: found \"\", allowed a number, together with PMIX_RANK");
  expect_refused({{"OMPI_COMM_WORLD_RANK", "1"}}, "OMPI_COMM_WORLD_SIZE: found \"\"");
  expect_refused({{"PMI_RANK", "4"}, {"PMI_SIZE", "4"}},
                 "PMI_RANK: found \"4\", allowed less than PMI_SIZE, 4");
  expect_refused({{"PMI_RANK", "-1"}, {"PMI_SIZE", "4"}}, "PMI_RANK: found \"-1\"");
  expect_refused({{"PMI_RANK", "1x"}, {"PMI_SIZE", "4"}}, "PMI_RANK: found \"1x\"");
}

}  // namespace
}  // namespace simuli::cli
