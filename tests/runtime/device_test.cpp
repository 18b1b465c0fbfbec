#include "host/device/runtime/device.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <memory>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/opencl.hpp"
#include "host/device/runtime/pending.hpp"
#include "tests/runtime/support.hpp"

namespace simuli {
namespace {

using test::contains;
using test::error_of;
using test::ScopedEnvironment;

TEST(Device, ThereIsAtLeastOne) { ASSERT_FALSE(Device::list().empty()) << "no OpenCL device: install PoCL"; }

TEST(Device, DescribesItself) {
  const Device device = test::open_device();
  const DeviceInfo& info = device.info();
  EXPECT_FALSE(info.platform.empty());
  EXPECT_FALSE(info.name.empty());
  EXPECT_FALSE(info.driver_version.empty());
  EXPECT_TRUE(info.device_version.starts_with("OpenCL "));
  EXPECT_TRUE(info.usable);
  EXPECT_GT(info.compute_units, 0U);
  EXPECT_GT(info.max_work_group_size, 0U);
  EXPECT_GE(info.global_bytes, info.max_alloc_bytes);
  // OpenCL 1.2 promises 32 KiB of local memory and 128 MiB or a quarter of the memory per buffer.
  EXPECT_GE(info.local_bytes, 32U * 1024U);
  EXPECT_GE(info.max_alloc_bytes, std::min<std::uint64_t>(info.global_bytes / 4, 128U << 20U));
  EXPECT_GT(device.quirks().usable_local_bytes, 0U);
  EXPECT_LE(device.quirks().usable_local_bytes, info.local_bytes);
  EXPECT_LE(device.quirks().prefers_explicit_vectors, info.is_cpu);  // not on every CPU
}

/// What a child of fork() says of `f`, which has 10 s.
std::string said_by_child(const std::function<void()>& f) {
  std::array<int, 2> ends{};
  EXPECT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(10);
    std::string said = "nothing";
    try {
      f();
    } catch (const Error& error) {
      said = error.what();
    }
    static_cast<void>(!::write(ends[1], said.data(), said.size()));
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string said;
  for (char c = 0; ::read(ends[0], &c, 1) == 1;) said += c;
  ::close(ends[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  return said;
}

TEST(Device, RefusesToWorkInAForkedChild) {
  auto device = std::make_unique<Device>(test::open_device());
  auto buffer = std::make_unique<Buffer<float>>(*device, "numbers", 4);
  buffer->upload(std::vector<float>{1.0F, 2.0F, 3.0F, 4.0F});
  const auto refuses = [](const std::function<void()>& f) {
    return contains(said_by_child(f), {"forked after devices were used", "use the spawn start method"});
  };
  EXPECT_TRUE(refuses([] { static_cast<void>(Device::list()); }));
  EXPECT_TRUE(refuses([] { static_cast<void>(Device::best()); }));
  EXPECT_TRUE(refuses([&] { device->finish(); }));
  EXPECT_TRUE(refuses([&] { static_cast<void>(buffer->download()); }));
  EXPECT_TRUE(refuses([&] { const Event event(*device); }));
  EXPECT_TRUE(
      refuses([&] { static_cast<void>(Device::adopt(opencl::context(*device), opencl::queue(*device))); }));
  EXPECT_EQ(said_by_child([&] {
              buffer.reset();
              device.reset();
            }),
            "nothing");
  EXPECT_EQ(buffer->download().at(3), 4.0F);  // the parent goes on
}

TEST(Device, ListHasGpusFirst) {
  const auto devices = Device::list();
  EXPECT_TRUE(std::is_partitioned(
      devices.begin(), devices.end(), [](const DeviceInfo& info) { return info.is_gpu; }));
}

TEST(Device, IsFoundByIndexAndByName) {
  const ScopedEnvironment unset("SIMULI_DEVICE", std::nullopt);
  const auto devices = Device::list();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!devices[i].usable) continue;
    EXPECT_EQ(Device::best(std::to_string(i)).info().label(), devices[i].label());
  }
  std::string shouted = devices.front().label();
  std::transform(shouted.begin(), shouted.end(), shouted.begin(), [](char c) {
    return static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  });
  EXPECT_EQ(Device::best(shouted).info().label(), devices.front().label());
}

TEST(Device, UnmatchedRequestListsTheDevices) {
  const std::string first = Device::list().front().label();
  EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [] { (void)Device::best("no such device"); }),
                       {"'no such device'", "[0]", first}));
  EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [] { (void)Device::best("123456"); }), {"'123456'"}));
}

TEST(Device, VariableIsARequestAndTheArgumentOverridesIt) {
  const ScopedEnvironment set("SIMULI_DEVICE", "no such device");
  EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [] { (void)Device::best(); }), {"no such device"}));
  EXPECT_NO_THROW((void)Device::best("0"));
}

TEST(Device, IsTakenForTheTypeThatTheVariableNames) {
  for (const char* const type : {"gpu", "cpu"}) {
    const ScopedEnvironment set("SIMULI_DEVICE_TYPE", type);
    const DeviceInfo info = Device::best().info();
    EXPECT_EQ(info.is_gpu, type == std::string("gpu"));
    EXPECT_EQ(info.is_cpu, type == std::string("cpu"));
  }
  const ScopedEnvironment set("SIMULI_DEVICE_TYPE", "tpu");
  EXPECT_TRUE(
      contains(error_of(ErrorKind::kUsage, [] { (void)Device::best(); }), {"'tpu'", "allowed cpu, gpu"}));
}

TEST(Device, AdoptsACallersContextAndQueue) {
  const Device own = test::open_device();
  const Device adopted = Device::adopt(opencl::context(own), opencl::queue(own));
  EXPECT_EQ(adopted.info().label(), own.info().label());
  EXPECT_FALSE(adopted.profile().enabled());
  const Buffer<int> buffer(adopted, "values", std::vector<int>{1, 2, 3});
  EXPECT_EQ(buffer.download(), (std::vector<int>{1, 2, 3}));
  const Device other = test::open_device();
  EXPECT_TRUE(contains(
      error_of(ErrorKind::kDevice, [&] { (void)Device::adopt(opencl::context(own), opencl::queue(other)); }),
      {"another context"}));
}

TEST(Device, RefusesAnOutOfOrderQueue) {
  const Device own = test::open_device();
  cl::CommandQueue queue;
  try {
    queue = cl::CommandQueue(cl::Context(opencl::context(own), true),
                             cl::Device(opencl::device_id(own), true),
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  } catch (const cl::Error&) {
    GTEST_SKIP() << "not run: out-of-order queues refused, this device has none";
  }
  EXPECT_TRUE(
      contains(error_of(ErrorKind::kDevice, [&] { (void)Device::adopt(opencl::context(own), queue()); }),
               {"out of order"}));
}

TEST(Device, CodesHaveNames) {
  EXPECT_EQ(cl_code_name(CL_OUT_OF_RESOURCES), "CL_OUT_OF_RESOURCES");
  EXPECT_EQ(cl_code_name(-1001), "CL_PLATFORM_NOT_FOUND_KHR");
  EXPECT_EQ(cl_code_name(12345), "unknown OpenCL code");
}

}  // namespace
}  // namespace simuli
