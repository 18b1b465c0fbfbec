#include "host/device/runtime/kernel.hpp"

#include <algorithm>

#include "tests/runtime/support.hpp"

namespace simuli {

namespace {
/// Shared with the kernel text below.
struct Step {
  float scale;
  std::uint32_t offset;
};
template <class real>
struct Line {
  real slope, start;
};
}  // namespace

template <>
struct ClTypeName<Step> {
  static constexpr std::string_view value = "Step";
};
template <>
struct ClTypeName<Line<double>> {
  static constexpr std::string_view value = "Line";
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
typedef struct { real slope, start; } Line;
__kernel void lines(__global const Line* line, __global real* out) {
  const uint i = get_global_id(0);
  out[i] = line[i].slope * (real)(2.0f) + line[i].start;
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

class KernelTest : public testing::Test {
 protected:
  Program build(Precision precision = Precision::kFloat) {
    return Program::from_text(device_, "test.cl", kText, BuildOptions().real(precision));
  }
  std::string refusal(const std::string& name, std::initializer_list<Binding> arguments) {
    return error_of(ErrorKind::kKernel, [&] { Kernel(build(), name).run(1, 1, arguments); });
  }
  Device device_ = test::open_device();
};

TEST_F(KernelTest, RunsWithBuffersScalarsAndStructs) {
  const Buffer<std::uint32_t> in(device_, "in", std::vector<std::uint32_t>{1, 2, 3});
  Buffer<float> range(device_, "range", 3);
  Kernel columns(build(), "columns");
  // In any order.
  columns.run(round_up(3, 4), 4, {{"n", 3U}, {"step", Step{0.5F, 1}}, {"in", in}, {"range", range}});
  EXPECT_EQ(range.download(), (std::vector<float>{1.0F, 1.5F, 2.0F}));
  columns.run(3, Range::none(), {{"in", in}, {"range", range}, {"n", 2U}, {"step", Step{2.0F, 0}}});
  EXPECT_EQ(range.download(), (std::vector<float>{2.0F, 4.0F, 2.0F}));
  EXPECT_EQ(columns.name(), "columns");
  EXPECT_GT(columns.max_local_size(), 0U);
}

TEST_F(KernelTest, BindingsHaveTheirValuesByThemselves) {
  const Buffer<std::uint32_t> in(device_, "in", std::vector<std::uint32_t>{1, 2, 3});
  Buffer<float> range(device_, "range", 3);
  Step step{0.5F, 1};
  const Binding bound{"step", step};
  step = {100.0F, 7};
  Kernel(build(), "columns").run(4, 4, {{"n", 3U}, bound, {"in", in}, {"range", range}});
  EXPECT_EQ(range.download(), (std::vector<float>{1.0F, 1.5F, 2.0F}));
}

TEST_F(KernelTest, BuffersOfSharedStructs) {
  const Buffer<Step> steps(device_, "steps", std::vector<Step>{{1, 4}, {2, 5}});
  Buffer<std::uint32_t> out(device_, "out", 2);
  Kernel(build(), "steps").run(2, 1, {{"steps", steps}, {"out", out}});
  EXPECT_EQ(out.download(), (std::vector<std::uint32_t>{4, 5}));
}

TEST_F(KernelTest, ThreeDimensions) {
  Buffer<std::uint32_t> out(device_, "out", 24);
  Kernel(build(), "coordinates").run({2, 3, 4}, {2, 1, 2}, {{"out", out}});
  const auto values = out.download();
  for (std::uint32_t i = 0; i < 24; ++i) {
    EXPECT_EQ(values[i], i % 2 + 10 * (i / 2 % 3) + 100 * (i / 6)) << i;
  }
}

TEST_F(KernelTest, LocalMemory) {
  Buffer<int> data(device_, "data", std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
  Kernel(build(), "reverse_group").run(8, 4, {{"data", data}, {"scratch", Local{4 * sizeof(int)}}});
  EXPECT_EQ(data.download(), (std::vector<int>{3, 2, 1, 0, 7, 6, 5, 4}));
}

TEST_F(KernelTest, RealFollowsThePrecision) {
  for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
    if (precision == Precision::kDouble && !device_.info().fp64) continue;
    RealBuffer in(device_, "in", precision);
    in.assign(std::span<const double>(std::vector<double>{1, -3}));
    RealBuffer out(device_, "out", precision, 2);
    Kernel(build(precision), "scale_real").run(2, 1, {{"in", in}, {"out", out}, {"factor", 0.1}});
    const bool wide = precision == Precision::kDouble;
    const double factor = wide ? 0.1 : static_cast<double>(0.1F);
    const double product = wide ? -3 * factor : static_cast<double>(-3 * 0.1F);
    EXPECT_EQ(out.download_double(), (std::vector<double>{factor, product}));
  }
}

TEST_F(KernelTest, RealAcceptsTheTypedBufferOfItsPrecision) {
  const Buffer<float> in(device_, "in", std::vector<float>{2});
  Buffer<float> out(device_, "out", 1);
  Kernel(build(), "scale_real").run(1, 1, {{"in", in}, {"out", out}, {"factor", 4.0F}});
  EXPECT_EQ(out.read_back(), 8.0F);
  const Buffer<double> wide(device_, "wide", std::vector<double>{2});
  EXPECT_EQ(refusal("scale_real", {{"in", wide}, {"out", out}, {"factor", 4.0F}}),
            "kernel scale_real: argument in is float*, the host passes double*");
}

TEST_F(KernelTest, StructsOfRealsFollowThePrecision) {
  for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
    if (precision == Precision::kDouble && !device_.info().fp64) continue;
    StructBuffer<Line> line(device_, "line", precision);
    line.assign(std::span<const double>(std::vector<double>{3, 1, -1, 0.5}));
    RealBuffer out(device_, "out", precision, 2);
    const StructBuffer<Line>& kept = line;
    Kernel(build(precision), "lines").run(2, 1, {{"line", kept}, {"out", out}});
    EXPECT_EQ(out.download_double(), (std::vector<double>{7, -1.5}));
  }
  const RealBuffer reals(device_, "reals", Precision::kFloat, 4);
  RealBuffer out(device_, "out", Precision::kFloat, 2);
  EXPECT_EQ(refusal("lines", {{"line", reals}, {"out", out}}),
            "kernel lines: argument line is Line*, the host passes float*");
  const StructBuffer<Line> wide(device_, "wide", Precision::kDouble, 4);
  EXPECT_EQ(refusal("lines", {{"line", wide}, {"out", out}}),
            "kernel lines: argument line is Line* of float, the host passes double");
}

TEST_F(KernelTest, RealBufferOfTheOtherPrecisionIsRefused) {
  Kernel scale(build(), "scale_real");
  RealBuffer in(device_, "in", Precision::kFloat, 1);
  RealBuffer out(device_, "out_wide", Precision::kDouble, 1);
  RealBuffer right(device_, "out", Precision::kFloat, 1);
  EXPECT_NO_THROW(scale.run(1, 1, {{"in", in}, {"out", right}, {"factor", 1.0}}));
  // At any launch, not at the first alone.
  EXPECT_EQ(error_of(ErrorKind::kKernel,
                     [&] {
                       scale.run(1, 1, {{"in", in}, {"out", out}, {"factor", 1.0}});
                     }),
            "kernel scale_real: argument out is float*, the host passes double*");
}

TEST_F(KernelTest, TypesAreCheckedAtTheFirstLaunch) {
  const Buffer<std::uint32_t> in(device_, "in", 1);
  Buffer<float> range(device_, "range", 1);
  const Buffer<float>& fixed = range;
  Buffer<std::uint32_t> words(device_, "words", 1);
  Buffer<int> data(device_, "data", 1);
  const Step step{};
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", words}, {"n", 1U}, {"step", step}}),
            "kernel columns: argument range is float*, the host passes uint*");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", range}, {"n", 1}, {"step", step}}),
            "kernel columns: argument n is uint, the host passes int");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", range}, {"n", 1U}, {"step", 1.0F}}),
            "kernel columns: argument step is Step, the host passes float");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", fixed}, {"n", 1U}, {"step", step}}),
            "kernel columns: argument range is float*, the host passes const float*");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", range}, {"n", words}, {"step", step}}),
            "kernel columns: argument n is a value, the host passes global memory");
  EXPECT_EQ(refusal("reverse_group", {{"data", data}, {"scratch", data}}),
            "kernel reverse_group: argument scratch is local memory, the host passes global memory");
  EXPECT_EQ(refusal("reverse_group", {{"data", Local{4}}, {"scratch", Local{4}}}),
            "kernel reverse_group: argument data is global memory, the host passes local memory");
}

TEST_F(KernelTest, EveryArgumentIsBoundOnce) {
  const Buffer<std::uint32_t> in(device_, "in", 1);
  Buffer<float> range(device_, "range", 1);
  const Step step{};
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", range}, {"step", step}}),
            "kernel columns: argument n is not bound");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"range", range}, {"n", 1U}, {"step", step}, {"in", in}}),
            "kernel columns: argument in is bound twice");
  EXPECT_EQ(refusal("columns", {{"in", in}, {"ranges", range}, {"n", 1U}, {"step", step}}),
            "kernel columns: there is no argument ranges among in, range, n, step");
  // A list that was right once doesn't excuse another.
  Kernel columns(build(), "columns");
  EXPECT_NO_THROW(columns.run(1, 1, {{"in", in}, {"range", range}, {"n", 1U}, {"step", step}}));
  EXPECT_EQ(error_of(ErrorKind::kKernel,
                     [&] {
                       columns.run(1, 1, {{"in", in}, {"range", range}, {"n", 1U}});
                     }),
            "kernel columns: argument step is not bound");
}

/// Two buffers that are known by their names.
struct Pair {
  void offer_to(Kernel& kernel) {
    kernel.offer("in", detail::kPassedBuffer<std::uint32_t>, in.memory());
    kernel.offer("range", detail::kPassedBuffer<float>, range.memory());
    kernel.offer("spare", detail::kPassedBuffer<float>, range.memory());
  }
  Buffer<std::uint32_t> in;
  Buffer<float> range;
};

TEST_F(KernelTest, AGroupBindsWhatTheKernelHas) {
  Pair pair{{device_, "in", std::vector<std::uint32_t>{4, 5}}, {device_, "range", 2}};
  Kernel columns(build(), "columns");
  for (const float scale : {2.0F, 3.0F}) {
    columns.run(2, 1, {pair, {"n", 2U}, {"step", Step{scale, 1}}});
    EXPECT_EQ(pair.range.download(), (std::vector<float>{5 * scale, 6 * scale}));
  }
  EXPECT_EQ(refusal("columns", {pair, {"in", pair.in}, {"n", 2U}, {"step", Step{}}}),
            "kernel columns: argument in is bound twice");
}

TEST_F(KernelTest, MissingKernelListsTheOthers) {
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, [&] { Kernel(build(), "absent"); }),
                       {"absent", "test.cl", "columns", "coordinates"}));
}

TEST(Declaration, IsReadFromTheText) {
  const auto kernels = kernel_declarations(R"(
#define SKIPPED __kernel void skipped(int a) \
  __kernel void skipped(int a)
// __kernel void comment(int a) {}
/* __kernel void other(int a) {} */
__attribute__((reqd_work_group_size(1, 1, 1))) kernel void first(
    const __global unsigned int* restrict a,  // of many, b
    __global real *const b, __constant struct Step* c, __local int* d, const sim_u32 e) { f(a, b); }
__kernel __attribute__((vec_type_hint(float))) void none() {}
)");
  ASSERT_EQ(kernels.size(), 2U);
  EXPECT_TRUE(kernels.at("none").empty());
  std::string found;
  for (const ArgumentDeclaration& a : kernels.at("first")) {
    found += a.name + ":" + a.type +
             (a.space == ArgumentSpace::kGlobal  ? "g"
              : a.space == ArgumentSpace::kLocal ? "l"
                                                 : "v");
    found += a.is_const && a.space != ArgumentSpace::kValue ? "c " : " ";
  }
  EXPECT_EQ(found, "a:uint*gc b:real*g c:Step*gc d:int*l e:sim_u32v ");
  EXPECT_EQ(error_of(ErrorKind::kKernel,
                     [] { (void)kernel_declarations("kernel void k(int a) {} kernel void k() {}"); }),
            "kernel k is declared twice");
}

TEST_F(KernelTest, GlobalSizeZeroLaunchesNothing) {
  const Device timed = test::open_device(true);
  const Program program = Program::from_text(timed, "test.cl", kText);
  Buffer<std::uint32_t> out(timed, "out", 1);
  out.fill(7);
  Kernel kernel(program, "coordinates");
  EXPECT_NO_THROW(kernel.run(0, 64, {{"out", out}}));
  EXPECT_NO_THROW(kernel.run({1, 0}, Range::none(), {{"out", out}}));
  EXPECT_NO_THROW(kernel.run({1, 1, 0}, {1, 1, 1}, {{"out", out}}));
  EXPECT_EQ(out.read_back(), 7U);
  EXPECT_TRUE(timed.profile().rows().empty());
}

TEST_F(KernelTest, RefusedLaunchNamesKernelAndSizes) {
  Buffer<std::uint32_t> out(device_, "out", 1);
  Kernel kernel(build(), "coordinates");
  const std::size_t local = 2 * device_.info().max_work_group_size;
  const std::string size = std::to_string(local);
  const auto too_large = [&] { kernel.run({2 * local, 1}, {local, 1}, {{"out", out}}); };
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, too_large),
                       {"clEnqueueNDRangeKernel failed: CL_INVALID_WORK_",
                        "kernel coordinates",
                        "global size " + std::to_string(2 * local) + " x 1",
                        "local size " + size + " x 1"}));
  const auto not_a_multiple = [&] { kernel.run(3, 2, {{"out", out}}); };
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, not_a_multiple),
                       {"CL_INVALID_WORK_GROUP_SIZE (-54)", "kernel coordinates"}));
}

TEST_F(KernelTest, BufferOfAnotherDeviceIsRefused) {
  const Device other = test::open_device();
  Buffer<std::uint32_t> out(other, "elsewhere", 1);
  Kernel kernel(build(), "coordinates");
  EXPECT_TRUE(contains(error_of(ErrorKind::kInternal,
                                [&] {
                                  kernel.run(1, 1, {{"out", out}});
                                }),
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
  Kernel coordinates(program, "coordinates");
  Kernel reverse(program, "reverse_group");
  for (int i = 0; i < 3; ++i) coordinates.run({2, 3, 4}, {1, 1, 1}, {{"out", out}});
  reverse.run(4, 4, {{"data", data}, {"scratch", Local{16}}});
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

/// How many work-items ran, and in groups of what size, as each of them saw it.
TEST_F(KernelTest, RunsOverACountInWholeGroups) {
  const Program program = Program::from_text(
      device_,
      "groups.cl",
      "__kernel void groups(__global uint* out) { out[get_global_id(0)] = get_local_size(0); }\n");
  const auto sizes = [&](std::size_t count) {
    Buffer<std::uint32_t> out(device_, "out", std::vector<std::uint32_t>(256, 0U));
    Kernel(program, "groups").run_over(count, {{"out", out}});
    return out.download();
  };
  const std::uint32_t group = sizes(1).front();
  EXPECT_GE(group, 32U);
  const std::vector<std::uint32_t> two_groups = sizes(group + 1);
  EXPECT_EQ(std::count(two_groups.begin(), two_groups.end(), group), 2 * group);
  EXPECT_EQ(sizes(0).front(), 0U);
}

TEST_F(KernelTest, ProfileIsOffByDefault) {
  EXPECT_FALSE(device_.profile().enabled());
  Buffer<std::uint32_t> out(device_, "out", 1);
  Kernel(build(), "coordinates").run(1, 1, {{"out", out}});
  device_.finish();
  EXPECT_TRUE(device_.profile().rows().empty());
}

}  // namespace
}  // namespace simuli
