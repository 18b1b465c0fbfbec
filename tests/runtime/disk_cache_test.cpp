#include "host/device/runtime/disk_cache.hpp"

#include <algorithm>

#include "host/device/runtime/kernel.hpp"
#include "tests/runtime/support.hpp"

namespace simuli {
namespace disk_cache_test {

namespace fs = std::filesystem;
using test::ScopedEnvironment;
using test::TemporaryFolder;

constexpr const char* kText =
    "__kernel void value_plus(__global int* out, const int add) { out[0] = VALUE + add; }\n";

class DiskCache : public testing::Test {
 protected:
  /// A build on a Device of its own, so that only the disk can remember; checks what it computes.
  static ProgramOrigin build(int value, const std::string& text = kText) {
    const Device device = test::open_device();
    const auto options = BuildOptions().define("VALUE", value);
    const Program program = Program::from_text(device, "value.cl", text, options);
    Buffer<int> out(device, "out", 1);
    Kernel(program, "value_plus").run(1, 1, {{"out", out}, {"add", 10}});
    EXPECT_EQ(out.read_back(), value + 10);
    return program.origin();
  }

  [[nodiscard]] std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_.path())) found.push_back(entry.path());
    return found;
  }

  TemporaryFolder folder_;
  ScopedEnvironment variable_{"SIMULI_CACHE_DIR", folder_.path().string()};
};

TEST_F(DiskCache, HitAndOptionAndTextChange) {
  EXPECT_EQ(build(1), ProgramOrigin::kCompiled);
  ASSERT_EQ(files().size(), 1U);
  EXPECT_EQ(files().front().extension(), ".clbin");  // and no temporary file is left
  EXPECT_EQ(build(1), ProgramOrigin::kDisk);
  EXPECT_EQ(build(2), ProgramOrigin::kCompiled);
  EXPECT_EQ(build(1, std::string(kText) + "// changed\n"), ProgramOrigin::kCompiled);
  EXPECT_EQ(files().size(), 3U);
}

TEST_F(DiskCache, DamagedFilesAreRebuilt) {
  // Twice: a driver that remembers what it has run of a program (PoCL) puts that into the second binary.
  ASSERT_EQ(build(1), ProgramOrigin::kCompiled);
  const fs::path file = files().front();
  fs::remove(file);
  ASSERT_EQ(build(1), ProgramOrigin::kCompiled);
  const std::string good = test::read_text(file);
  auto flipped = [&](std::size_t at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    return bytes;
  };
  const std::vector<std::string> damaged = {
      "",
      good.substr(0, 10),
      good.substr(0, good.size() / 2),
      good.substr(0, good.size() - 1),
      good + "x",
      flipped(0),
      flipped(30),               // a length
      flipped(good.find("-D")),  // the key
      flipped(good.size() - 1),  // the binary
  };
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    test::write_text(file, damaged[i]);
    EXPECT_EQ(build(1), ProgramOrigin::kCompiled) << "case " << i;
    EXPECT_EQ(test::read_text(file).size(), good.size()) << "case " << i << " was not healed";
  }
  EXPECT_EQ(build(1), ProgramOrigin::kDisk);
}

TEST_F(DiskCache, BinaryTheDriverRefusesIsRebuilt) {
  ASSERT_EQ(build(1), ProgramOrigin::kCompiled);
  const std::string text = test::read_text(files().front());
  const std::size_t key_first = text.find("simuli program binary", 1);
  const std::size_t source_end = text.find(kText) + std::string_view(kText).size();
  ASSERT_LT(key_first, source_end);
  // A well-formed entry around bytes that are no program.
  save_binary(text.substr(key_first, source_end - key_first), ProgramBinary(100, 0x5a));
  ASSERT_EQ(files().size(), 1U);
  EXPECT_EQ(build(1), ProgramOrigin::kCompiled);
  EXPECT_EQ(build(1), ProgramOrigin::kDisk);
}

TEST_F(DiskCache, KeyHasDriverAndOptions) {
  DeviceInfo info = test::open_device().info();
  const std::string key = program_key(info, "-D A=1", "text");
  EXPECT_NE(key, program_key(info, "-D A=2", "text"));
  EXPECT_NE(key, program_key(info, "-D A=1", "other"));
  info.driver_version += ".1";
  EXPECT_NE(key, program_key(info, "-D A=1", "text"));
  save_binary(key, {1, 2, 3});
  EXPECT_EQ(load_binary(key), (ProgramBinary{1, 2, 3}));
  EXPECT_FALSE(load_binary(key + "x").has_value());
}

TEST_F(DiskCache, UnwritableFolderDoesNotMatter) {
  test::write_text(folder_.path() / "file", "a file, so no folder can be inside it");
  const ScopedEnvironment below("SIMULI_CACHE_DIR", (folder_.path() / "file" / "below").string());
  EXPECT_EQ(build(1), ProgramOrigin::kCompiled);
  EXPECT_EQ(build(1), ProgramOrigin::kCompiled);
}

TEST_F(DiskCache, EmptyVariableTurnsItOff) {
  const ScopedEnvironment off("SIMULI_CACHE_DIR", "");
  EXPECT_FALSE(cache_folder().has_value());
  EXPECT_EQ(build(1), ProgramOrigin::kCompiled);
  EXPECT_TRUE(files().empty());
}

TEST_F(DiskCache, FolderFollowsTheVariables) {
  EXPECT_EQ(cache_folder(), folder_.path());
  const ScopedEnvironment unset("SIMULI_CACHE_DIR", std::nullopt);
  const ScopedEnvironment home("HOME", "/home/somebody");
  {
    const ScopedEnvironment xdg("XDG_CACHE_HOME", "/var/cache/somebody");
    EXPECT_EQ(cache_folder(), fs::path("/var/cache/somebody/simuli"));
  }
  const ScopedEnvironment relative("XDG_CACHE_HOME", "not/absolute");
  EXPECT_EQ(cache_folder(), fs::path("/home/somebody/.cache/simuli"));
}

}  // namespace disk_cache_test
}  // namespace simuli
