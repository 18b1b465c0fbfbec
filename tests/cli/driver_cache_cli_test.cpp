// PoCL's cache: read-only, damaged.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/cli/cli_fixture.hpp"

namespace {

using namespace simuli::test;

class DriverCacheCli : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    if (run("devices").out.find("Portable Computing Language") == std::string::npos) {
      GTEST_SKIP() << "not run: PoCL's cache, there is no PoCL";
    }
  }
  /// "simuli ARGUMENTS" with that home; the status as of waitpid.
  int run_at(const fs::path& home, const std::string& arguments) const {
    const std::string command = fmt::format(
        "cd '{}' && export HOME='{}' && unset XDG_CACHE_HOME SIMULI_CACHE_DIR POCL_CACHE_DIR && exec '{}' {} >out.txt "
        "2>err.txt",
        folder_.string(),
        home.string(),
        SIMULI_PROGRAM,
        arguments);
    return std::system(command.c_str());
  }
  [[nodiscard]] std::string errors() const {
    std::ifstream file(folder_ / "err.txt");
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(DriverCacheCli, AHomeThatCannotBeWrittenIsNoMissingDevice) {
  EXPECT_EQ(run_at("/proc/no-home", "devices --json"), 0) << errors();
  EXPECT_NE(errors().find("note: PoCL can't write its cache /proc/no-home"), std::string::npos) << errors();
}

TEST_F(DriverCacheCli, ADamagedCacheEndsOneRunNotAll) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "not run: crashes in PoCL's cache, AddressSanitizer tells of them itself";
#endif
  const fs::path home = folder_ / "home";
  fs::create_directory(home);
  ASSERT_EQ(run_at(home, "devices --check"), 0) << errors();
  EXPECT_EQ(errors(), "");  // nor how many warnings PoCL's compiler has
  std::vector<fs::path> libraries;
  for (const auto& entry : fs::recursive_directory_iterator(home / ".cache" / "pocl")) {
    if (entry.path().extension() == ".so") libraries.push_back(entry.path());
  }
  ASSERT_FALSE(libraries.empty());
  // PoCL maps the one, which is cut, and crashes; it ends the process itself where it can't open the other,
  // with the handlers of its compiler in place.
  const auto crashes = [&] {
    ASSERT_NE(run_at(home, "devices --check"), 0) << "PoCL takes care of it now";
    EXPECT_NE(errors().find("simuli: crashed, in the OpenCL driver or by a defect"), std::string::npos)
        << errors();
    ASSERT_EQ(run_at(home, "devices --check"), 0) << errors();
    EXPECT_NE(errors().find("note: the run before crashed: PoCL's cache is "), std::string::npos) << errors();
    ASSERT_EQ(run_at(home, "devices --check"), 0) << errors();
    EXPECT_EQ(errors(), "");
  };
  constexpr std::uintmax_t kHeader = 3000;
  for (const fs::path& library : libraries)
    fs::resize_file(library, std::min(kHeader, fs::file_size(library)));
  crashes();
  fs::remove(home / ".cache" / "simuli" / "crashes");
  fs::remove_all(home / ".cache" / "simuli" / "pocl.1");
  for (const fs::path& library : libraries)
    std::ofstream(library) << "\x7f"
                              "ELF others";
  crashes();
}

}  // namespace
