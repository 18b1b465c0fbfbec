#include "host/device/runtime/buffer.hpp"

#include <limits>
#include <numeric>
#include <optional>

#include "host/device/runtime/opencl.hpp"
#include "host/device/runtime/real_buffer.hpp"
#include "tests/runtime/support.hpp"

namespace simuli {
namespace {

using test::contains;
using test::error_of;

struct Triple {
  std::uint32_t a, b, c;
  bool operator==(const Triple&) const = default;
};

class BufferTest : public testing::Test {
 protected:
  Device device_ = test::open_device();
};

TEST_F(BufferTest, RoundTrip) {
  std::vector<std::uint32_t> values(1000);
  std::iota(values.begin(), values.end(), 7U);
  Buffer<std::uint32_t> buffer(device_, "values", values);
  EXPECT_EQ(buffer.count(), values.size());
  EXPECT_EQ(buffer.download(), values);
  std::vector<std::uint32_t> target(values.size());
  buffer.download(target);
  EXPECT_EQ(target, values);
  EXPECT_EQ(buffer.read_back(), 7U);
  EXPECT_EQ(buffer.read_back(999), 1006U);
}

TEST_F(BufferTest, Ranges) {
  Buffer<int> buffer(device_, "values", std::vector<int>{0, 1, 2, 3, 4});
  buffer.upload_at(2, std::vector<int>{20, 30});
  EXPECT_EQ(buffer.download(), (std::vector<int>{0, 1, 20, 30, 4}));
  std::vector<int> part(2);
  buffer.download_at(3, part);
  EXPECT_EQ(part, (std::vector<int>{30, 4}));
  buffer.upload_at(5, std::span<const int>());  // an empty range at the end is ordinary
}

TEST_F(BufferTest, RowsThatLieApart) {
  Buffer<int> buffer(device_, "table", std::vector<int>(12, -1));
  const std::vector<int> values{0, 1, 10, 11, 20, 21};
  buffer.queue_rows(2, 4, 2, values);
  EXPECT_EQ(buffer.download(), (std::vector<int>{-1, -1, 0, 1, -1, -1, 10, 11, -1, -1, 20, 21}));
  buffer.queue_rows(0, 6, 6, values);
  EXPECT_EQ(buffer.download(), (std::vector<int>{0, 1, 10, 11, 20, 21, 10, 11, -1, -1, 20, 21}));
  buffer.queue_rows(5, 1, 0, {});
  // One row too many, and rows that overlap.
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { buffer.queue_rows(3, 4, 2, values); }),
                       {"table", "10", "12"}));
  EXPECT_TRUE(
      contains(error_of(ErrorKind::kInternal, [&] { buffer.queue_rows(0, 1, 2, values); }), {"table"}));
}

TEST_F(BufferTest, WrongRangesAreRefusedByName) {
  Buffer<int> buffer(device_, "depth", 3);
  const std::vector<int> four(4);
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { buffer.upload(four); }), {"depth", "4", "3"}));
  std::vector<int> two(2);
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { buffer.download(two); }), {"depth", "2", "3"}));
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { buffer.upload_at(2, two); }), {"depth"}));
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { (void)buffer.read_back(3); }), {"depth"}));
  constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { buffer.upload_at(kHuge, two); }), {"depth"}));
}

TEST_F(BufferTest, EmptyIsOrdinary) {
  Buffer<float> buffer(device_, "nothing");
  EXPECT_EQ(buffer.count(), 0U);
  EXPECT_TRUE(buffer.download().empty());
  EXPECT_NO_THROW(buffer.upload({}));
  EXPECT_NO_THROW(buffer.fill(1.0F));
  EXPECT_NE(opencl::memory(buffer), nullptr);
}

TEST_F(BufferTest, Fill) {
  Buffer<float> floats(device_, "floats", 5);
  floats.fill(2.5F);
  EXPECT_EQ(floats.download(), std::vector<float>(5, 2.5F));
  Buffer<std::uint8_t> bytes(device_, "bytes", 3);
  bytes.fill(255);
  EXPECT_EQ(bytes.download(), std::vector<std::uint8_t>(3, 255));
}

TEST_F(BufferTest, FillOfASizeNoDeviceFillsItself) {
  // 12 bytes, and more than one host chunk (1 MiB).
  constexpr std::size_t kCount = 200'000;
  Buffer<Triple> buffer(device_, "triples", kCount);
  const Triple value{1, 2, 3};
  buffer.fill(value);
  EXPECT_EQ(buffer.download(), std::vector<Triple>(kCount, value));
}

TEST_F(BufferTest, ReserveGrowsOnly) {
  Buffer<int> buffer(device_, "scratch", std::vector<int>{1, 2, 3, 4});
  const cl_mem first = opencl::memory(buffer);
  buffer.reserve(2);
  EXPECT_EQ(buffer.count(), 2U);
  EXPECT_EQ(buffer.capacity(), 4U);
  EXPECT_EQ(opencl::memory(buffer), first);
  EXPECT_EQ(buffer.download(), (std::vector<int>{1, 2}));
  buffer.reserve(100);
  EXPECT_EQ(buffer.count(), 100U);
  EXPECT_EQ(buffer.capacity(), 100U);
  buffer.assign(std::vector<int>{5, 6});
  EXPECT_EQ(buffer.download(), (std::vector<int>{5, 6}));
  EXPECT_EQ(buffer.capacity(), 100U);
}

TEST_F(BufferTest, OversizeIsRefusedBeforeAllocation) {
  const std::uint64_t allowed = device_.info().max_alloc_bytes;
  const std::size_t count = allowed / sizeof(double) + 1;
  Buffer<double> buffer(device_, "keys", 3);
  EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [&] { buffer.reserve(count); }),
                       {"buffer keys", std::to_string(count), std::to_string(allowed)}));
  // What is left is a valid, empty buffer.
  EXPECT_EQ(buffer.count(), 0U);
  buffer.assign(std::vector<double>{4});
  EXPECT_EQ(buffer.read_back(), 4);
  constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();
  EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [&] { Buffer<double> huge(device_, "huge", kHuge); }),
                       {"buffer huge"}));
}

TEST_F(BufferTest, CopyOnTheDevice) {
  const Buffer<int> source(device_, "source", std::vector<int>{3, 1, 2});
  Buffer<int> target(device_, "target", 3);
  target.copy_from(source);
  EXPECT_EQ(target.download(), source.download());
  Buffer<int> shorter(device_, "shorter", 2);
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { shorter.copy_from(source); }),
                       {"shorter", "source", "3", "2"}));
}

TEST_F(BufferTest, MovesAndOutlivesItsDeviceHandle) {
  std::optional<Device> device(test::open_device());
  Buffer<int> first(*device, "moved", std::vector<int>{1, 2});
  device.reset();
  Buffer<int> second(std::move(first));
  EXPECT_EQ(second.download(), (std::vector<int>{1, 2}));
}

TEST_F(BufferTest, RealConverts) {
  const std::vector<double> values{0.1, -2.0, 1e30};
  RealBuffer narrow(device_, "narrow", Precision::kFloat);
  narrow.assign(std::span<const double>(values));
  EXPECT_EQ(narrow.download_float(), (std::vector<float>{0.1F, -2.0F, 1e30F}));
  EXPECT_EQ(narrow.download_double().front(), static_cast<double>(0.1F));
  EXPECT_EQ(narrow.as_float().count(), 3U);
  EXPECT_TRUE(
      contains(error_of(ErrorKind::kInternal, [&] { (void)narrow.as_double(); }), {"narrow", "precision"}));

  RealBuffer wide(device_, "wide", Precision::kDouble, 3);
  wide.upload(std::span<const double>(values));
  EXPECT_EQ(wide.download_double(), values);
  EXPECT_EQ(wide.download_float().front(), 0.1F);
  wide.fill(0.25);
  EXPECT_EQ(wide.download_double(), std::vector<double>(3, 0.25));
  EXPECT_EQ(wide.precision(), Precision::kDouble);
  EXPECT_THROW(wide.copy_from(narrow), Error);
}

}  // namespace
}  // namespace simuli
