// Which part of the jobs a process does, as launchers say it.
#include "host/cli/batch/shard.hpp"

#include <gtest/gtest.h>
#include <map>
#include <string>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

using Variables = std::map<std::string, std::string>;

Environment of(const Variables& variables) {
  return [variables = std::make_shared<Variables>(variables)](const char* name) -> const char* {
    const auto at = variables->find(name);
    return at == variables->end() ? nullptr : at->second.c_str();
  };
}

void expect_shard(const Variables& variables, std::size_t index, std::size_t count) {
  const Shard shard = shard_in(of(variables));
  EXPECT_EQ(shard.index, index);
  EXPECT_EQ(shard.count, count);
}

void expect_refused(const Variables& variables, const std::string& part) {
  try {
    static_cast<void>(shard_in(of(variables)));
    FAIL() << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Shard, EveryLauncherIsUnderstood) {
  expect_shard({}, 0, 1);
  expect_shard({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 2, 4);
  expect_shard({{"PMI_RANK", "1"}, {"PMI_SIZE", "3"}}, 1, 3);
  expect_shard({{"PMIX_RANK", "5"}, {"SLURM_NTASKS", "8"}}, 5, 8);
  // OpenMPI says both, and the size in its own words alone.
  expect_shard({{"PMIX_RANK", "3"}, {"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 3, 4);
  // A batch script outside of any step has the number of tasks, too, and is one process.
  expect_shard({{"SLURM_NTASKS", "8"}, {"SLURM_PROCID", "0"}}, 0, 1);
}

TEST(Shard, ArraysCountFromTheirFirstInTheirSteps) {
  expect_shard({{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_COUNT", "4"}}, 0, 4);
  const Variables stepped{{"SLURM_ARRAY_TASK_ID", "11"},
                          {"SLURM_ARRAY_TASK_MIN", "5"},
                          {"SLURM_ARRAY_TASK_STEP", "3"},
                          {"SLURM_ARRAY_TASK_COUNT", "4"}};
  expect_shard(stepped, 2, 4);
  // One task that is run again alone does everything that is left.
  expect_shard(
      {{"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_MIN", "7"}, {"SLURM_ARRAY_TASK_COUNT", "1"}}, 0, 1);
  Variables ranks = stepped;
  ranks["PMI_RANK"] = "1";
  ranks["PMI_SIZE"] = "2";
  expect_shard(ranks, 5, 8);
}

TEST(Shard, WhatDoesNotFitIsRefused) {
  expect_refused({{"PMIX_RANK", "1"}}, "SLURM_NTASKS: found \"\", allowed a number beside PMIX_RANK");
  expect_refused({{"OMPI_COMM_WORLD_RANK", "1"}}, "OMPI_COMM_WORLD_SIZE: found \"\"");
  expect_refused({{"PMI_RANK", "4"}, {"PMI_SIZE", "4"}},
                 "PMI_RANK: found \"4\", allowed less than PMI_SIZE, 4");
  expect_refused({{"PMI_RANK", "-1"}, {"PMI_SIZE", "4"}}, "PMI_RANK: found \"-1\"");
  expect_refused({{"PMI_RANK", "1x"}, {"PMI_SIZE", "4"}}, "PMI_RANK: found \"1x\"");
  expect_refused({{"SLURM_ARRAY_TASK_ID", "3"}}, "SLURM_ARRAY_TASK_COUNT: found \"\"");
  // --array=1,2,7: nobody tells the third that it is the third.
  expect_refused(
      {{"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_MIN", "1"}, {"SLURM_ARRAY_TASK_COUNT", "3"}},
      "SLURM_ARRAY_TASK_ID: found \"7\", allowed one of 3 from 1 in steps of 1");
  expect_refused({{"SLURM_ARRAY_TASK_ID", "6"},
                  {"SLURM_ARRAY_TASK_MIN", "1"},
                  {"SLURM_ARRAY_TASK_STEP", "2"},
                  {"SLURM_ARRAY_TASK_COUNT", "9"}},
                 "SLURM_ARRAY_TASK_ID: found \"6\"");
  expect_refused(
      {{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_STEP", "0"}, {"SLURM_ARRAY_TASK_COUNT", "1"}},
      "steps of 0");
}

TEST(Shard, AsOneWrites) {
  EXPECT_EQ(parse_shard("0/1").count, 1U);
  EXPECT_EQ(parse_shard("3/4").index, 3U);
  for (const char* text : {"4/4", "1", "", "/", "1/", "/2", "-1/2", "0/0", "1/2/3", "a/b", " 1/2", "1/2 "}) {
    EXPECT_THROW(static_cast<void>(parse_shard(text)), Error) << text;
  }
}

}  // namespace
}  // namespace simuli::cli
