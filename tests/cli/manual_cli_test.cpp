// Completion scripts and the manual page: what the shells make of them.
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "tests/cli/cli_fixture.hpp"

namespace manual_cli_test {

using namespace simuli::test;

class ManualCli : public Cli {
 protected:
  /// What bash offers for the last of these words.
  std::vector<std::string> completed(const std::vector<std::string>& words) const {
    std::ofstream script(folder_ / "ask.sh");
    script << "compopt() { :; }\n. ./simuli.bash\nCOMP_WORDS=(simuli";
    for (const std::string& word : words) script << " '" << word << "'";
    script << ")\nCOMP_CWORD=" << words.size()
           << "\n_simuli\nprintf '%s\\n' \"${COMPREPLY[@]}\" >offered.txt\n";
    script.close();
    EXPECT_EQ(std::system(fmt::format("cd '{}' && bash -u ask.sh", folder_.string()).c_str()), 0);
    std::ifstream offered(folder_ / "offered.txt");
    std::vector<std::string> lines;
    for (std::string line; std::getline(offered, line);) {
      if (!line.empty()) lines.push_back(line);
    }
    return lines;
  }
};

using Words = std::vector<std::string>;

TEST_F(ManualCli, BashCompletesCommandsOptionsAndValues) {
  const Outcome script = run("completion bash");
  ASSERT_EQ(script.exit_code, 0) << script.err;
  std::ofstream(folder_ / "simuli.bash") << script.out;
  EXPECT_EQ(completed({"tra"}), Words{"train"});
  EXPECT_EQ(completed({"--json", "tra"}), Words{"train"});
  EXPECT_EQ(completed({"import", "kitti3"}), Words{"kitti360"});
  EXPECT_EQ(completed({"train", "--iter"}), Words{"--iterations"});
  EXPECT_EQ(completed({"train", "s.log", "--qual"}), Words{"--quality"});
  EXPECT_EQ(completed({"train", "--quality", "dr"}), Words{"draft"});
  EXPECT_EQ(completed({"render", "s.scene", "--sensor", "hesai_xt16"}), Words{"hesai_xt16"});
  EXPECT_EQ(completed({"train", "--set", "seed=2", "init.voxel"}), (Words{"init.voxel_m="}));
  EXPECT_EQ(completed({"train", "--seed", "2", "init.voxel"}), Words{});  // no value of --seed, nor a file
  EXPECT_EQ(completed({"render", "--images", ""}), (Words{"png", "jpeg", "exr", "raw"}));
  std::ofstream(folder_ / "generic.json") << "{}";
  EXPECT_EQ(completed({"info", "generic"}), (Words{"generic64", "generic.json"}));
}

/// Parentheses and quotes that don't match, and the like.
TEST_F(ManualCli, BashReadsItsScript) {
  const Outcome script = run("completion bash");
  ASSERT_EQ(script.exit_code, 0) << script.err;
  EXPECT_NE(script.out.find("hesai_pandar64"), std::string::npos);
  EXPECT_NE(script.out.find("kitti360"), std::string::npos);
  EXPECT_NE(script.out.find("init.voxel_m"), std::string::npos);
  std::ofstream(folder_ / "script.bash") << script.out;
  EXPECT_EQ(std::system(fmt::format("cd '{}' && bash -n script.bash", folder_.string()).c_str()), 0);
  expect_failure("completion zsh", kUsage, "found zsh, allowed bash");
}

TEST_F(ManualCli, ManualPageHasEveryCommand) {
  const Outcome page = run("manual");
  ASSERT_EQ(page.exit_code, 0) << page.err;
  for (const char* part : {".TH simuli 1 ",
                           ".SH NAME\nsimuli \\- ",
                           ".SS simuli train LOG \\-o TEXT [OPTIONS]\nfit a scene to a log\n",
                           ".SS simuli import kitti DIR ",
                           ".B \\-\\-iterations INT|auto\n",
                           ".SH EXIT STATUS\n"}) {
    EXPECT_NE(page.out.find(part), std::string::npos) << part << " is missing";
  }
  std::istringstream lines(page.out);
  for (std::string line; std::getline(lines, line);) {
    const bool is_request = line.starts_with(".TH ") || line.starts_with(".S") || line.starts_with(".TP") ||
                            line.starts_with(".B ");
    EXPECT_TRUE(is_request || (!line.starts_with('.') && !line.starts_with('\''))) << line;
  }
}

}  // namespace manual_cli_test
