#include "host/runtime/kernel.hpp"

#include "tests/runtime/support.hpp"

namespace simuli {

namespace {
/// Shared with the kernel text below.
struct Step {
  float scale;
  std::uint32_t offset;
};
}  // namespace

template <>
struct ClTypeName<Step> {
  static constexpr std::string_view value = "Step";
};

namespace {

using test::contains;
using test::error_of;

constexpr const char* kText = R"(
#ifdef SIMULI_REAL_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#else
typedef float real;
#endif
typedef uint sim_u32;
typedef struct { float scale; sim_u32 offset; } Step;
__kernel void columns(__global const uint* in, __global float* range, const sim_u32 n, const Step step) {
  const uint i = get_global_id(0);
  if (i < n) range[i] = step.scale * (float)(in[i] + step.offset);
}
__kernel void steps(__global const Step* steps, __global uint* out) {
  const uint i = get_global_id(0);
  out[i] = steps[i].offset;
}
__kernel void scale_real(__global const real* in, __global real* out, const real factor) {
  const uint i = get_global_id(0);
  out[i] = in[i] * factor;
}
__kernel void reverse_group(__global int* data, __local int* scratch) {
  scratch[get_local_id(0)] = data[get_global_id(0)];
  barrier(CLK_LOCAL_MEM_FENCE);
  data[get_global_id(0)] = scratch[get_local_size(0) - 1 - get_local_id(0)];
}
__kernel void coordinates(__global uint* out) {
  const uint x = get_global_id(0), y = get_global_id(1), z = get_global_id(2);
  out[x + get_global_size(0) * (y + get_global_size(1) * z)] = x + 10 * y + 100 * z;
}
)";

using Columns = Kernel<Buf<const std::uint32_t>, Buf<float>, std::uint32_t, Step>;

class KernelTest : public testing::Test {
 protected:
  Program build(Precision precision = Precision::kFloat) {
    return Program::from_text(device_, "test.cl", kText, BuildOptions().real(precision));
  }
  template <class K>
  std::string refusal(const std::string& name) {
    return error_of(ErrorKind::kKernel, [&] { K(build(), name); });
  }
  Device device_ = test::open_device();
};

TEST_F(KernelTest, RunsWithBuffersScalarsAndStructs) {
  const Buffer<std::uint32_t> in(device_, "in", std::vector<std::uint32_t>{1, 2, 3});
  Buffer<float> range(device_, "range", 3);
  Columns columns(build(), "columns");
  columns.launch(round_up(3, 4), 4, in, range, 3, Step{0.5F, 1});
  EXPECT_EQ(range.download(), (std::vector<float>{1.0F, 1.5F, 2.0F}));
  columns.launch(3, Range::none(), in, range, 2, Step{2.0F, 0});
  EXPECT_EQ(range.download(), (std::vector<float>{2.0F, 4.0F, 2.0F}));
  EXPECT_EQ(columns.name(), "columns");
  EXPECT_GT(columns.max_local_size(), 0U);
}

TEST_F(KernelTest, BuffersOfSharedStructs) {
  const Buffer<Step> steps(device_, "steps", std::vector<Step>{{1, 4}, {2, 5}});
  Buffer<std::uint32_t> out(device_, "out", 2);
  Kernel<Buf<const Step>, Buf<std::uint32_t>>(build(), "steps").launch(2, 1, steps, out);
  EXPECT_EQ(out.download(), (std::vector<std::uint32_t>{4, 5}));
}

TEST_F(KernelTest, ThreeDimensions) {
  Buffer<std::uint32_t> out(device_, "out", 24);
  Kernel<Buf<std::uint32_t>>(build(), "coordinates").launch({2, 3, 4}, {2, 1, 2}, out);
  const auto values = out.download();
  for (std::uint32_t i = 0; i < 24; ++i) {
    EXPECT_EQ(values[i], i % 2 + 10 * (i / 2 % 3) + 100 * (i / 6)) << i;
  }
}

TEST_F(KernelTest, LocalMemory) {
  Buffer<int> data(device_, "data", std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
  Kernel<Buf<int>, Local>(build(), "reverse_group").launch(8, 4, data, Local{4 * sizeof(int)});
  EXPECT_EQ(data.download(), (std::vector<int>{3, 2, 1, 0, 7, 6, 5, 4}));
}

TEST_F(KernelTest, RealFollowsThePrecision) {
  using Scale = Kernel<BufRealConst, BufReal, RealScalar>;
  for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
    if (precision == Precision::kDouble && !device_.info().fp64) continue;
    RealBuffer in(device_, "in", precision);
    in.assign(std::span<const double>(std::vector<double>{1, -3}));
    RealBuffer out(device_, "out", precision, 2);
    Scale(build(precision), "scale_real").launch(2, 1, in, out, 0.1);
    const bool wide = precision == Precision::kDouble;
    const double factor = wide ? 0.1 : static_cast<double>(0.1F);
    const double product = wide ? -3 * factor : static_cast<double>(-3 * 0.1F);
    EXPECT_EQ(out.download_double(), (std::vector<double>{factor, product}));
  }
}

TEST_F(KernelTest, RealAcceptsTheTypedBufferOfItsPrecision) {
  const Buffer<float> in(device_, "in", std::vector<float>{2});
  Buffer<float> out(device_, "out", 1);
  Kernel<Buf<const float>, Buf<float>, float>(build(), "scale_real").launch(1, 1, in, out, 4.0F);
  EXPECT_EQ(out.read_back(), 8.0F);
  EXPECT_EQ((refusal<Kernel<Buf<const double>, Buf<double>, double>>("scale_real")),
            "kernel scale_real: argument 0 is float*, the host passes double*");
}

TEST_F(KernelTest, RealBufferOfTheOtherPrecisionIsRefused) {
  Kernel<BufRealConst, BufReal, RealScalar> scale(build(), "scale_real");
  RealBuffer in(device_, "in", Precision::kFloat, 1);
  RealBuffer out(device_, "out_wide", Precision::kDouble, 1);
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { scale.launch(1, 1, in, out, 1.0); }),
                       {"scale_real", "argument 1", "out_wide", "precision"}));
}

TEST_F(KernelTest, TypesAreCheckedAtCreation) {
  EXPECT_EQ((refusal<Kernel<Buf<const std::uint32_t>, Buf<std::uint32_t>, std::uint32_t, Step>>("columns")),
            "kernel columns: argument 1 is float*, the host passes uint*");
  EXPECT_EQ((refusal<Kernel<Buf<const std::uint32_t>, Buf<float>, std::int32_t, Step>>("columns")),
            "kernel columns: argument 2 is uint, the host passes int");
  EXPECT_EQ((refusal<Kernel<Buf<const std::uint32_t>, Buf<float>, std::uint32_t, float>>("columns")),
            "kernel columns: argument 3 is Step, the host passes float");
  EXPECT_EQ((refusal<Kernel<Buf<const std::uint32_t>, Buf<float>>>("columns")),
            "kernel columns: it has 4 arguments, the host passes 2");
  EXPECT_EQ((refusal<Kernel<Buf<const std::uint32_t>, Buf<const float>, std::uint32_t, Step>>("columns")),
            "kernel columns: argument 1 is float*, the host passes const float*");
  EXPECT_EQ((refusal<Kernel<Buf<int>, Buf<int>>>("reverse_group")),
            "kernel reverse_group: argument 1 is local memory, the host passes global memory");
  EXPECT_EQ((refusal<Kernel<Local, Local>>("reverse_group")),
            "kernel reverse_group: argument 0 is global memory, the host passes local memory");
}

TEST_F(KernelTest, MissingKernelListsTheOthers) {
  EXPECT_TRUE(contains(refusal<Kernel<Buf<int>>>("absent"), {"absent", "test.cl", "columns", "coordinates"}));
}

TEST_F(KernelTest, GlobalSizeZeroLaunchesNothing) {
  const Device timed = test::open_device(true);
  const Program program = Program::from_text(timed, "test.cl", kText);
  Buffer<std::uint32_t> out(timed, "out", 1);
  out.fill(7);
  Kernel<Buf<std::uint32_t>> kernel(program, "coordinates");
  EXPECT_NO_THROW(kernel.launch(0, 64, out));
  EXPECT_NO_THROW(kernel.launch({1, 0}, Range::none(), out));
  EXPECT_NO_THROW(kernel.launch({1, 1, 0}, {1, 1, 1}, out));
  EXPECT_EQ(out.read_back(), 7U);
  EXPECT_TRUE(timed.profile().rows().empty());
}

TEST_F(KernelTest, RefusedLaunchNamesKernelAndSizes) {
  Buffer<std::uint32_t> out(device_, "out", 1);
  Kernel<Buf<std::uint32_t>> kernel(build(), "coordinates");
  const std::size_t local = 2 * device_.info().max_work_group_size;
  const std::string size = std::to_string(local);
  const auto too_large = [&] { kernel.launch({2 * local, 1}, {local, 1}, out); };
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, too_large),
                       {"clEnqueueNDRangeKernel failed: CL_INVALID_WORK_",
                        "kernel coordinates",
                        "global size " + std::to_string(2 * local) + " x 1",
                        "local size " + size + " x 1"}));
  const auto not_a_multiple = [&] { kernel.launch(3, 2, out); };
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, not_a_multiple),
                       {"CL_INVALID_WORK_GROUP_SIZE (-54)", "kernel coordinates"}));
}

TEST_F(KernelTest, BufferOfAnotherDeviceIsRefused) {
  const Device other = test::open_device();
  Buffer<std::uint32_t> out(other, "elsewhere", 1);
  Kernel<Buf<std::uint32_t>> kernel(build(), "coordinates");
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { kernel.launch(1, 1, out); }),
                       {"coordinates", "elsewhere", "another device"}));
}

TEST_F(KernelTest, RoundUp) {
  EXPECT_EQ(round_up(0, 64), 0U);
  EXPECT_EQ(round_up(1, 64), 64U);
  EXPECT_EQ(round_up(64, 64), 64U);
  EXPECT_EQ(round_up(65, 64), 128U);
}

TEST_F(KernelTest, ProfileHasARowPerKernel) {
  const Device timed = test::open_device(true);
  const Program program = Program::from_text(timed, "test.cl", kText);
  Buffer<std::uint32_t> out(timed, "out", 24);
  Buffer<int> data(timed, "data", 4);
  data.fill(0);
  Kernel<Buf<std::uint32_t>> coordinates(program, "coordinates");
  Kernel<Buf<int>, Local> reverse(program, "reverse_group");
  for (int i = 0; i < 3; ++i) coordinates.launch({2, 3, 4}, {1, 1, 1}, out);
  reverse.launch(4, 4, data, Local{16});
  const auto rows = timed.profile().rows();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_GE(rows[0].total_ms, rows[1].total_ms);
  for (const ProfileRow& row : rows) {
    EXPECT_EQ(row.count, row.kernel == "coordinates" ? 3U : 1U) << row.kernel;
    EXPECT_GE(row.min_ms, 0.0);
    EXPECT_LE(row.min_ms * static_cast<double>(row.count), row.total_ms * (1 + 1e-12));  // sum of rounded
  }
  timed.profile().reset();
  EXPECT_TRUE(timed.profile().rows().empty());
}

TEST_F(KernelTest, ProfileIsOffByDefault) {
  EXPECT_FALSE(device_.profile().enabled());
  Buffer<std::uint32_t> out(device_, "out", 1);
  Kernel<Buf<std::uint32_t>>(build(), "coordinates").launch(1, 1, out);
  device_.finish();
  EXPECT_TRUE(device_.profile().rows().empty());
}

}  // namespace
}  // namespace simuli
