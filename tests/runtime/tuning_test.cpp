#include "host/device/runtime/tuning.hpp"

#include "host/device/runtime/kernel.hpp"
#include "tests/runtime/support.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::ScopedEnvironment;
using test::TemporaryFolder;

constexpr DeviceTuning kTuning{.lanes = 8, .vectors = 32, .work_items = 1, .group = 16};

class Tuning : public testing::Test {
 protected:
  TemporaryFolder folder_;
  ScopedEnvironment variable_{"SIMULI_CACHE_DIR", folder_.path().string()};
};

TEST_F(Tuning, IsFoundByTheSameDeviceAlone) {
  const DeviceInfo device = test::open_device().info();
  EXPECT_FALSE(stored_tuning(device));
  save_tuning(device, kTuning);
  EXPECT_EQ(stored_tuning(device), kTuning);
  DeviceInfo other = device;
  other.driver_version += " newer";
  EXPECT_FALSE(stored_tuning(other));
  EXPECT_EQ(tuning_of(test::open_device()), kTuning);

  save_tuning(device, {});
  EXPECT_FALSE(stored_tuning(device));
  EXPECT_EQ(tuning_of(test::open_device()), DeviceTuning{});
}

TEST_F(Tuning, DamagedFilesAreNone) {
  const DeviceInfo device = test::open_device().info();
  save_tuning(device, kTuning);
  const fs::path file = fs::directory_iterator(folder_.path())->path();
  fs::resize_file(file, fs::file_size(file) - 1);
  EXPECT_FALSE(stored_tuning(device));
}

TEST_F(Tuning, ACacheThatCannotBeWrittenIsAnError) {
  const DeviceInfo device = test::open_device().info();
  const ScopedEnvironment none("SIMULI_CACHE_DIR", "");
  try {
    save_tuning(device, kTuning);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find("SIMULI_CACHE_DIR"), std::string::npos) << error.what();
  }
}

/// How many work-items ran, and in groups of what size, as the last of them saw it.
TEST_F(Tuning, DecidesTheGroupsOfKernelsRunOverACount) {
  const Device device = test::open_device();
  const Program program = Program::from_text(
      device,
      "groups.cl",
      "__kernel void groups(__global uint* out) { out[get_global_id(0)] = get_local_size(0); }\n");
  const auto sizes = [&](std::size_t count, std::size_t room) {
    Buffer<std::uint32_t> out(device, "out", std::vector<std::uint32_t>(room, 0U));
    Kernel(program, "groups").run_over(count, {{"out", out}});
    return out.download();
  };
  set_tuning(device, {.group = 4});
  EXPECT_EQ(sizes(6, 9), (std::vector<std::uint32_t>{4, 4, 4, 4, 4, 4, 4, 4, 0}));
  set_tuning(device, {});
  EXPECT_GE(sizes(1, 256).front(), 32U);
  EXPECT_EQ(sizes(0, 2), (std::vector<std::uint32_t>{0, 0}));
}

}  // namespace
}  // namespace simuli
