// simuli batch: what is made, what is skipped, what is told.
#include <algorithm>
#include <chrono>
#include <set>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <thread>

#include "tests/cli/batch/batch_fixture.hpp"

namespace {

using namespace simuli::test;

class BatchCommandCli : public BatchCli {};

TEST_F(BatchCommandCli, JobsAreTheCommandsOnTheirOwn) {
  write_jobs(R"({"name": "picture", "run": ["render", "s.scene", "--sensor", "front", "-o", "out/a"]},
                {"name": "moved", "run": ["render", "s.scene", "--sensor", "top", "--move", "car:0,-1,0",
                                          "--set", "render.sh_degree=2", "-o", "out/b"]},
                {"name": "shifted", "run": ["render", "s.scene", "--sensor", "front", "--lane-shift", "1",
                                            "-o", "out/c"]},
                {"name": "again", "run": ["render", "s.scene", "--sensor", "top", "-o", "out/d"]},
                {"name": "trained", "run": ["train", "s.log", "--iterations", 3, "--set", "init.voxel_m=0.5",
                                            "-o", "out/t.scene"]},
                {"name": "told", "run": ["info", "out/t.scene", "--json"], "stdout": "out/t.json"},
                {"name": "splats", "run": ["export", "out/t.scene", "-o", "out/t.ply"]})");
  const Outcome outcome = run("batch jobs.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  for (const char* command :
       {"render s.scene --sensor front -o own/a",
        "render s.scene --sensor top --move car:0,-1,0 --set render.sh_degree=2 -o own/b",
        "render s.scene --sensor front --lane-shift 1 -o own/c",
        "render s.scene --sensor top -o own/d",
        "train s.log --iterations 3 --set init.voxel_m=0.5 -o own/t.scene",
        "export own/t.scene -o own/t.ply"}) {
    const Outcome own = run(command);
    ASSERT_EQ(own.exit_code, 0) << own.err;
  }
  auto made = files_in(folder_ / "out");
  EXPECT_EQ(made.at("t.json"), run("info out/t.scene --json").out);
  made.erase("t.json");
  EXPECT_EQ(made, files_in(folder_ / "own"));
}

TEST_F(BatchCommandCli, WhatIsDoneIsSkippedAndOnlyThat) {
  write_jobs(renders(4));
  EXPECT_EQ(states(run("--json batch jobs.json --list").out),
            (States{{"r0", "due"}, {"r1", "due"}, {"r2", "due"}, {"r3", "due"}}));
  const Outcome first = run("batch jobs.json");
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("made 1/4 r0: "), std::string::npos) << first.out;
  EXPECT_EQ(std::count(first.out.begin(), first.out.end(), '\n'), 4) << first.out;
  const auto files = files_in(folder_ / "out");
  const auto time = fs::last_write_time(folder_ / "out/r1/frames.json");
  EXPECT_EQ(run("batch jobs.json").out, "done 1/4 r0\ndone 2/4 r1\ndone 3/4 r2\ndone 4/4 r3\n");
  EXPECT_EQ(fs::last_write_time(folder_ / "out/r1/frames.json"), time);
  // Whatever file of jobs it stands in, as long as it is the same job.
  write_jobs(renders(2), "fewer.json");
  EXPECT_EQ(run("batch fewer.json").out, "done 1/2 r0\ndone 2/2 r1\n");

  const auto expect_made = [&](const std::string& more, const States& expected) {
    const Outcome outcome = run("--json batch jobs.json" + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    EXPECT_EQ(states(outcome.out), expected) << outcome.out;
    EXPECT_EQ(count(states(run("--json batch jobs.json" + more).out), "done"), 4);
  };
  // One whose words are others.
  std::string jobs = renders(4);
  jobs.replace(jobs.find("0:0"), 3, "1:1");
  write_jobs(jobs);
  expect_made("", {{"r0", "made"}, {"r1", "done"}, {"r2", "done"}, {"r3", "done"}});
  EXPECT_FALSE(fs::exists(folder_ / "out/r0/front_000000.png"));
  write_jobs(renders(4));
  expect_made("", {{"r0", "made"}, {"r1", "done"}, {"r2", "done"}, {"r3", "done"}});
  EXPECT_EQ(files_in(folder_ / "out"), files);
  // One whose output is gone, and one whose record is.
  fs::remove_all(folder_ / "out/r2");
  expect_made("", {{"r0", "done"}, {"r1", "done"}, {"r2", "made"}, {"r3", "done"}});
  EXPECT_EQ(files_in(folder_ / "out"), files);
  // All whose input is another, and all for another quality.
  fs::last_write_time(folder_ / "s.scene/camera.ply",
                      fs::last_write_time(folder_ / "s.scene/camera.ply") + std::chrono::seconds(1));
  expect_made("", {{"r0", "made"}, {"r1", "made"}, {"r2", "made"}, {"r3", "made"}});
  expect_made(" --quality draft", {{"r0", "made"}, {"r1", "made"}, {"r2", "made"}, {"r3", "made"}});
  expect_made("", {{"r0", "made"}, {"r1", "made"}, {"r2", "made"}, {"r3", "made"}});
  EXPECT_EQ(files_in(folder_ / "out"), files);
  // Another program may make it otherwise.
  std::string record = content(folder_ / "out/r3.job");
  const std::string program = "\"program\": \"simuli ";
  ASSERT_NE(record.find(program), std::string::npos);
  record.insert(record.find(program) + program.size(), "0.0.1 ");
  write("out/r3.job", record);
  expect_made("", {{"r0", "done"}, {"r1", "done"}, {"r2", "done"}, {"r3", "made"}});
}

TEST_F(BatchCommandCli, NobodysFilesAreReplaced) {
  write_jobs(renders(3));
  fs::create_directories(folder_ / "out/r1");
  write("out/r1/mine.txt", "mine");
  const Outcome first = run("--json batch jobs.json");
  EXPECT_EQ(first.exit_code, kInput);
  EXPECT_EQ(states(first.out), (States{{"r0", "made"}, {"r1", "failed"}, {"r2", "made"}}));
  EXPECT_NE(first.out.find("out/r1: output: found something of that name that no job has made"),
            std::string::npos)
      << first.out;
  EXPECT_EQ(content(folder_ / "out/r1/mine.txt"), "mine");
  // Nor what was put into an output.
  write("out/r0/mine.txt", "mine");
  const Outcome second = run("--json batch jobs.json");
  EXPECT_EQ(states(second.out), (States{{"r0", "failed"}, {"r1", "failed"}, {"r2", "done"}}));
  EXPECT_NE(second.out.find("changed since a job made it"), std::string::npos) << second.out;
  EXPECT_EQ(content(folder_ / "out/r0/mine.txt"), "mine");
  const Outcome third = run("--json batch jobs.json --overwrite");
  EXPECT_EQ(third.exit_code, 0) << third.out;
  EXPECT_EQ(states(third.out), (States{{"r0", "made"}, {"r1", "made"}, {"r2", "done"}}));
  EXPECT_FALSE(fs::exists(folder_ / "out/r0/mine.txt"));
}

TEST_F(BatchCommandCli, FailuresAreToldAndTheOthersGoOn) {
  write_jobs(R"({"name": "nothing", "run": ["render", "absent.scene", "--sensor", "front", "-o", "out/n"]},
                {"name": "reads", "run": ["export", "out/n", "-o", "out/n.ply"]},
                {"name": "usage", "run": ["render", "s.scene", "--sensor", "front", "--size", "0x0",
                                          "-o", "out/u"]},
                {"name": "diverges", "run": ["train", "s.log", "--iterations", 40, "--set",
                                             "init.voxel_m=0.5", "camera.rate.sh=100", "-o", "out/d.scene"]},)" +
             renders(1));
  const Outcome outcome = run("--json batch jobs.json");
  constexpr int kNumeric = 6;
  EXPECT_EQ(outcome.exit_code, kNumeric) << outcome.err;
  EXPECT_EQ(outcome.err, "simuli: batch: 4 of 5 jobs failed\n");
  EXPECT_EQ(states(outcome.out),
            (States{{"nothing", "failed"},
                    {"reads", "failed"},
                    {"usage", "failed"},
                    {"diverges", "failed"},
                    {"r0", "made"}}));
  EXPECT_NE(outcome.out.find(R"("exit_code":3)"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(R"(job \"nothing\" has failed, whose output it reads)"), std::string::npos);
  EXPECT_NE(outcome.out.find("PSNR of the training pictures fell"), std::string::npos) << outcome.out;
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_ / "out")) names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"d.scene.job", "n.job", "r0", "r0.job", "u.job"}));
  // What has failed is due again.
  EXPECT_EQ(count(states(run("--json batch jobs.json --list").out), "due"), 4);
}

TEST_F(BatchCommandCli, EveryShardDoesItsOwn) {
  write_jobs(renders(7));
  struct Launch {
    const char* name;
    std::vector<std::string> variables;
  };
  const auto rank = [](int r) {
    const std::string i = std::to_string(r), id = std::to_string(10 + 2 * r);
    return std::vector<Launch>{{"ompi", {"OMPI_COMM_WORLD_RANK=" + i, "OMPI_COMM_WORLD_SIZE=3"}},
                               {"pmi", {"PMI_RANK=" + i, "PMI_SIZE=3"}},
                               {"pmix", {"PMIX_RANK=" + i, "SLURM_NTASKS=3"}},
                               {"array",
                                {"SLURM_ARRAY_TASK_ID=" + id,
                                 "SLURM_ARRAY_TASK_MIN=10",
                                 "SLURM_ARRAY_TASK_STEP=2",
                                 "SLURM_ARRAY_TASK_COUNT=3"}}};
  };
  for (std::size_t k = 0; k < rank(0).size(); ++k) {
    States all;
    for (int r = 0; r < 3; ++r) {
      const Launch launch = rank(r)[k];
      const auto program = start(launch.variables, {"--json", "batch", "jobs.json", "--list"}, "list.txt");
      ASSERT_EQ(program->end_by(0), 0) << launch.name << program->output();
      const States own = states(program->output());
      EXPECT_EQ(own.contains(fmt::format("r{}", r)), true) << launch.name;
      EXPECT_EQ(own.size(), r == 0 ? 3U : 2U) << launch.name << program->output();
      all.insert(own.begin(), own.end());
    }
    EXPECT_EQ(all.size(), 7U) << rank(0)[k].name;
  }
  const auto lost = start({"PMIX_RANK=1"}, {"batch", "jobs.json"}, "lost.txt");
  EXPECT_EQ(lost->end_by(0), kUsage) << lost->output();
  EXPECT_EQ(states(run("--json batch jobs.json --shard 2/3").out), (States{{"r2", "made"}, {"r5", "made"}}));
  expect_failure("batch jobs.json --shard 3/3", kUsage, "--shard: found \"3/3\", allowed K/N");
}

TEST_F(BatchCommandCli, TwoAtATimeMakeEachJobOnce) {
  write_jobs(renders(24));
  const auto first = start({}, {"--json", "batch", "jobs.json"}, "first.txt");
  const auto second = start({}, {"--json", "batch", "jobs.json"}, "second.txt");
  EXPECT_EQ(first->end_by(0), 0) << first->output();
  EXPECT_EQ(second->end_by(0), 0) << second->output();
  const States a = states(first->output()), b = states(second->output());
  EXPECT_EQ(a.size(), 24U);
  EXPECT_EQ(b.size(), 24U);
  EXPECT_EQ(count(a, "made") + count(b, "made"), 24) << first->output() << second->output();
}

TEST_F(BatchCommandCli, WhatIsNotAllowedIsSaidBeforeAnyJob) {
  write_jobs(R"({"run": ["render", "s.scene", "--sensr", "front", "-o", "a"]})");
  expect_failure("batch jobs.json", kInput, "jobs.json: jobs[0].run: found option \"--sensr\", did you mean");
  write_jobs(R"({"run": ["info", "s.scene"]})");
  expect_failure("batch jobs.json", kInput, "jobs[0].run: found a command without an output");
  write_jobs(R"({"run": ["render", "--help"]})");
  expect_failure("batch jobs.json", kInput, "jobs[0].run: found a question, allowed a command to run");
  write_jobs(R"({"run": ["train", "s.log", "-o", "a", "--set", "help"]})");
  expect_failure("batch jobs.json", kInput, "jobs[0].run: found a question");
  write_jobs(
      R"({"run": ["train", "s.log", "-o", "a"]}, {"run": ["render", "s.scene", "-o", "a.checkpoint"]})");
  expect_failure("batch jobs.json", kInput, "an output of job \"a\", too, allowed each output once");
  write_jobs(renders(2) + R"(, {"run": ["batch", "jobs.json"], "stdout": "b.txt"})");
  EXPECT_EQ(run("batch jobs.json").exit_code, kUsage);
  write("jobs.json", R"({"format": "simuli batch", "version": 1, "jobs": [{"run": ["render", )");
  expect_failure("batch jobs.json", kInput, "jobs.json: ");
  expect_failure("batch absent.json", kInput, "absent.json");
  expect_failure("batch", kUsage, "JOBS");
  expect_failure("batch jobs.json -- render", kUsage, "allowed with --vary");
}

TEST_F(BatchCommandCli, ASweepIsAFileOfJobs) {
  const std::string sweep =
      "batch sweep.json --vary car.move.left=-1:1:1 --vary lane_shift=0,1.5 -- "
      "render s.scene --sensor front --frames 0:0 -o 'out/{}'";
  EXPECT_EQ(run(sweep).out, "6 jobs in sweep.json\n");
  expect_failure(sweep, kInput, "sweep.json: file: found something of that name");
  const Outcome made = run("batch sweep.json");
  EXPECT_EQ(made.exit_code, 0) << made.err << made.out;
  ASSERT_EQ(
      run("render s.scene --sensor front --frames 0:0 --move car:0,-1,0 --lane-shift 1.5 -o own").exit_code,
      0);
  EXPECT_EQ(files_in(folder_ / "out/car.move.left=-1,lane_shift=1.5"), files_in(folder_ / "own"));
  EXPECT_EQ(files_in(folder_ / "out").size(), 12U);
  expect_failure("batch a.json --vary lane_shft=1 -- render s.scene --sensor front -o '{}'",
                 kUsage,
                 "while varying lane_shft=1: found option \"--lane-shft\", did you mean");
  expect_failure("batch a.json --vary lane_shift=1", kUsage, "allowed one behind \"--\"");
  expect_failure(
      "batch a.json --vary lane_shift=1 -- render s.scene -o a", kUsage, "{} in its output's name");
  EXPECT_FALSE(fs::exists(folder_ / "a.json"));
}

}  // namespace
