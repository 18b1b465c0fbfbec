// Files of jobs, and which process does which of them.
#include "host/cli/batch/jobs.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// "make OUTPUT INPUT...", "go OUTPUT" leaves OUTPUT.unfinished, "look" makes nothing.
Work work_of(const Words& words) {
  Work work;
  if (words[0] == "look") return work;
  if (words.size() < 2) throw Error(ErrorKind::kUsage, "found no output");
  work.makes = {words[1]};
  if (words[0] == "go") work.unfinished = {words[1] + ".unfinished"};
  work.reads.assign(words.begin() + 2, words.end());
  return work;
}

class JobsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "simuli_jobs_XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    old_ = fs::current_path();
    fs::current_path(folder_);
  }
  void TearDown() override {
    fs::current_path(old_);
    fs::remove_all(folder_);
  }
  static std::vector<Job> read_text(const std::string& text) {
    std::ofstream("jobs.json") << text;
    return read_jobs("jobs.json", {}, work_of);
  }
  static std::vector<Job> read(const std::string& jobs) {
    return read_text(R"({"format": "simuli batch", "version": 1, "jobs": [)" + jobs + "]}");
  }
  static void expect_refused(const std::string& jobs, const std::string& what) {
    try {
      static_cast<void>(jobs.starts_with('!') ? read_text(jobs.substr(1)) : read(jobs));
      FAIL() << what;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      const std::string line = error.what();
      EXPECT_NE(line.find("jobs.json"), std::string::npos) << line;
      EXPECT_NE(line.find(what), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
  fs::path folder_, old_;
};

TEST_F(JobsTest, WhatAJobSays) {
  const std::vector<Job> jobs = read(R"({"name": "a", "run": ["make", "out/a", "in", 1.5]},
                                        {"run": ["make", "b/"]},
                                        {"name": "c", "run": ["look"], "stdout": "c.txt"})");
  ASSERT_EQ(jobs.size(), 3U);
  EXPECT_EQ(jobs[0].words, (Words{"make", "out/a", "in", "1.5"}));
  EXPECT_EQ(jobs[1].name, "b/");
  EXPECT_EQ(jobs[2].output(), "c.txt");
  std::ofstream("jobs.json") << R"({"format": "simuli batch", "version": 1, "jobs": [{"run": ["a"]}]})";
  EXPECT_EQ(read_jobs("jobs.json", {"make"}, work_of)[0].output(), "a");
}

TEST_F(JobsTest, WhatIsNoFileOfJobsIsRefused) {
  expect_refused("!", "jobs.json");
  expect_refused("!{\"format\": \"simuli batch\", \"version\": 1, \"jobs\": [", "line 1");
  expect_refused("![]", "jobs.json");
  expect_refused(R"(!{"format": "other", "version": 1, "jobs": []})", "format: found \"other\"");
  expect_refused(R"(!{"format": "simuli batch", "version": 2, "jobs": []})", "version: found 2");
  expect_refused(R"(!{"format": "simuli batch", "version": 1})", "jobs");
  expect_refused("3", "jobs[0]");
  expect_refused(R"({"run": "make a"})", "jobs[0].run: found \"make a\", allowed a list");
  expect_refused(R"({"run": []})", "jobs[0].run: found []");
  expect_refused(R"({"run": ["make", null]})", "jobs[0].run: found [\"make\",null]");
  expect_refused(R"({"run": ["make", "a"]}, {"rum": ["make", "b"]})", "jobs[1].run");
  expect_refused(R"({"run": ["make", "a"], "outputs": 1})", "jobs[0].outputs");
  expect_refused(R"({"run": ["make"]})", "jobs[0].run: found no output");
  expect_refused(R"({"run": ["look"]})", "jobs[0].run: found a command without an output");
  expect_refused(R"({"run": ["look"], "stdout": ""})", "jobs[0].stdout");
  expect_refused(R"({"name": "a", "run": ["make", "a"]}, {"name": "a", "run": ["make", "b"]})",
                 "jobs[1].name: found \"a\", the name of jobs[0], too, allowed each name once");
}

TEST_F(JobsTest, NoTwoJobsMakeTheSame) {
  const std::string a = R"({"name": "first", "run": ["make", "out/a"]}, )";
  for (const char* same : {"out/a", "out/a/", "./out/a", "out/../out/a"}) {
    expect_refused(a + R"({"run": ["make", ")" + same + R"("]})", "an output of job \"first\", too");
  }
  expect_refused(a + R"({"run": ["make", ")" + (folder_ / "out/a").string() + R"("]})", "\"first\", too");
  expect_refused(a + R"({"run": ["make", "out/a/b"]})", "within an output of job \"first\"");
  expect_refused(a + R"({"run": ["make", "out"]})", "jobs[0].run");
  // Nor what stands beside an output.
  expect_refused(a + R"({"run": ["make", "out/a.job"]})", "an output of job \"first\", too");
  expect_refused(R"({"run": ["go", "a"]}, {"run": ["make", "a.unfinished"]})", "an output of job \"a\", too");
  // The same folder by another name.
  fs::create_directory("out");
  fs::create_directory_symlink("out", "link");
  expect_refused(a + R"({"run": ["make", "link/a"]})", "an output of job \"first\", too");
  expect_refused(R"({"name": "told", "run": ["look", "x"], "stdout": "s"}, {"run": ["make", "s"]})", "job \"told\"");
  EXPECT_EQ(read(a + R"({"run": ["make", "out/ab"]})").size(), 2U);
}

TEST_F(JobsTest, WhoReadsStandsBehindWhoMakes) {
  const std::vector<Job> jobs = read(R"({"run": ["make", "s", "log"]}, {"run": ["make", "t", "log"]},
                                        {"run": ["make", "r", "s/"]}, {"run": ["make", "u", "./s/part", "t"]})");
  EXPECT_TRUE(jobs[0].needs.empty());
  EXPECT_TRUE(jobs[1].needs.empty());
  EXPECT_EQ(jobs[2].needs, (std::vector<std::size_t>{0}));
  EXPECT_EQ(jobs[3].needs, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(read(R"({"run": ["make", "all/a"]}, {"run": ["make", "b", "all"]})")[1].needs.size(), 1U);
  expect_refused(R"({"run": ["make", "r", "s"]}, {"name": "late", "run": ["make", "s"]})",
                 "jobs[0].run: found s, which job \"late\" behind it makes");
  expect_refused(R"({"run": ["make", "s/report", "s"]})", "found s, which it reads and makes something of");
}

TEST_F(JobsTest, ShardsTakeTurns) {
  std::string text;
  for (int i = 0; i < 10; ++i) {
    text += (i > 0 ? ", " : "") + std::string(R"({"run": ["make", "o)") + std::to_string(i) + "\"";
    if (i == 4) text += R"(, "o1")";  // with the first one's shard
    if (i == 7) text += R"(, "o4")";
    text += "]}";
  }
  const std::vector<Job> jobs = read(text);
  using Own = std::vector<std::size_t>;
  EXPECT_EQ(jobs_of(jobs, {0, 1}), (Own{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(jobs_of(jobs, {0, 3}), (Own{0, 3, 8}));
  EXPECT_EQ(jobs_of(jobs, {1, 3}), (Own{1, 4, 5, 7, 9}));
  EXPECT_EQ(jobs_of(jobs, {2, 3}), (Own{2, 6}));
  for (const std::size_t count : {1U, 2U, 5U, 16U}) {
    std::vector<int> times(jobs.size(), 0);
    for (std::size_t index = 0; index < count; ++index) {
      for (const std::size_t job : jobs_of(jobs, {index, count})) ++times[job];
    }
    EXPECT_EQ(times, std::vector<int>(jobs.size(), 1)) << count;
  }
}

}  // namespace
}  // namespace simuli::cli
