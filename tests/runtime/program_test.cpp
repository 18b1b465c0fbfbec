#include "host/device/runtime/program.hpp"

#include "host/device/runtime/kernel.hpp"
#include "host/device/runtime/source.hpp"
#include "tests/runtime/support.hpp"

namespace simuli {
namespace {

using test::contains;
using test::error_of;
using test::ScopedEnvironment;
using test::TemporaryFolder;
using test::write_text;

constexpr const char* kConstant = "__kernel void constant_value(__global int* out) { out[0] = VALUE; }\n";

#define SKIP_WITHOUT_LINES(device)                                                      \
  if ((device).quirks().ignores_line_directives) {                                      \
    GTEST_SKIP() << "not run: lines in build logs, this driver numbers them by itself"; \
  }                                                                                     \
  static_assert(true)

int run_constant(const Program& program) {
  Buffer<int> out(program.device(), "out", 1);
  Kernel(program, "constant_value").run(1, 1, {{"out", out}});
  return out.read_back();
}

/// Kernel files on disk, used in place of the embedded ones.
class SourceFolder : public testing::Test {
 protected:
  void write(const std::string& path, std::string_view text) { write_text(folder_.path() / path, text); }

  TemporaryFolder folder_;
  ScopedEnvironment variable_{"SIMULI_CL_DIR", folder_.path().string()};
};

enum class Shape : std::uint8_t { kRound = 3 };

TEST(BuildOptions, AreCanonical) {
  BuildOptions options;
  options.define("ZETA", 1).define("ALPHA", -2).define("ALPHA", 5U).define("KIND", Shape::kRound);
  options.define("FLAG", true);
  EXPECT_EQ(options.text(), "-cl-std=CL1.2 -cl-kernel-arg-info -w -D ALPHA=5 -D FLAG=1 -D KIND=3 -D ZETA=1");
  options.real(Precision::kDouble);
  EXPECT_TRUE(contains(options.text(), {"-D SIMULI_REAL_DOUBLE=1"}));
  options.real(Precision::kFloat);
  EXPECT_EQ(options.text().find("DOUBLE"), std::string::npos);
}

TEST(BuildOptions, AreThoseThatATextNames) {
  BuildOptions options;
  options.real(Precision::kDouble).define("V", 4).define("MOVING", true).define("MOV", 1).define("END", 2);
  const std::string text = options.named_in("#if MOVING // V, MOV\nint V_1, AV = END").text();
  EXPECT_EQ(text, "-cl-std=CL1.2 -cl-kernel-arg-info -w -D SIMULI_REAL_DOUBLE=1 -D END=2 -D MOVING=1");
}

TEST(BuildOptions, RefuseWhatIsNoIdentifier) {
  for (const char* name : {"", "1A", "A B", "A=1 -D B", "SIMULI_REAL_DOUBLE"}) {
    EXPECT_TRUE(contains(error_of(ErrorKind::kInternal, [&] { BuildOptions().define(name, 1); }), {name}));
  }
}

TEST(Source, EmbeddedTextIsThatOfTheFiles) {
  const std::filesystem::path root(SIMULI_TEST_CL_ROOT);
  if (!exists(root)) GTEST_SKIP() << "not run: the files of the build, which was made on another machine";
  for (const EmbeddedFile& file : embedded_files()) {
    EXPECT_EQ(file.text, test::read_text(root / file.path)) << file.path;
    EXPECT_EQ(load_source(file.path), file.text);
  }
  EXPECT_EQ(std::string(SIMULI_TEST_CL_COUNT), std::to_string(embedded_files().size()));
}

TEST(Source, MissingFileIsNamed) {
  const auto wrong = [] { (void)expand_file("kernels/nothing.cl"); };
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, wrong), {"cl/kernels/nothing.cl", "embedded"}));
}

TEST_F(SourceFolder, IncludesAreSplicedOnceWithLineDirectives) {
  write("kernels/main.cl", "#include \"math/a.h\"\n  # include \"cl/math/b.h\"\nmain\n#include <cstdint>\n");
  write("math/a.h", "#pragma once\n#include \"b.h\"\r\na");
  write("math/b.h", "b\n");
  EXPECT_EQ(expand_file("kernels/main.cl"),
            "#line 1 \"cl/kernels/main.cl\"\n"
            "#line 1 \"cl/math/a.h\"\n"
            "\n"
            "#line 1 \"cl/math/b.h\"\n"
            "b\n"
            "#line 3 \"cl/math/a.h\"\n"
            "a\n"
            "#line 2 \"cl/kernels/main.cl\"\n"
            "\n"
            "main\n"
            "#include <cstdint>\n");
}

TEST_F(SourceFolder, IncludeCyclesEnd) {
  write("a.h", "#include \"b.h\"\na\n");
  write("b.h", "#include \"a.h\"\nb\n");
  EXPECT_TRUE(contains(expand_file("a.h"), {"\nb\n", "\na\n"}));
}

TEST_F(SourceFolder, MissingIncludeIsNamedWithItsLine) {
  write("kernels/main.cl", "// first\n#include \"math/gone.h\"\n");
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, [] { (void)expand_file("kernels/main.cl"); }),
                       {"cl/kernels/main.cl:2", "math/gone.h", folder_.path().string()}));
}

TEST_F(SourceFolder, EditedFilesAreUsed) {
  const Device device = test::open_device();
  write("kernels/constant.cl", "#include \"value.h\"\n" + std::string(kConstant));
  write("kernels/value.h", "#define VALUE 5\n");
  EXPECT_EQ(run_constant(Program(device, "kernels/constant.cl")), 5);
  write("kernels/value.h", "#define VALUE 6\n");
  EXPECT_EQ(run_constant(Program(device, "kernels/constant.cl")), 6);
}

TEST_F(SourceFolder, BuildErrorNamesTheIncludedFileAndLine) {
  const Device device = test::open_device();
  SKIP_WITHOUT_LINES(device);
  write("kernels/main.cl",
        "#include \"math/broken.h\"\n__kernel void k(__global int* out) { out[0] = LANES; }\n");
  write("math/broken.h", "// one\n// two\nint broken( { return 1; }\n");
  const std::string message = error_of(ErrorKind::kKernel, [&] {
    (void)Program(device, "kernels/main.cl", BuildOptions().define("LANES", 4));
  });
  EXPECT_TRUE(contains(message, {"cl/kernels/main.cl", "-D LANES=4", "cl/math/broken.h:3"}));
}

TEST_F(SourceFolder, BuildErrorAfterAnIncludeKeepsItsLine) {
  const Device device = test::open_device();
  SKIP_WITHOUT_LINES(device);
  write("kernels/main.cl", "#include \"math/fine.h\"\n\nint broken( { return 1; }\n");
  write("math/fine.h", "// one\n// two\n// three\n");
  EXPECT_TRUE(contains(error_of(ErrorKind::kKernel, [&] { (void)Program(device, "kernels/main.cl"); }),
                       {"cl/kernels/main.cl:3"}));
}

TEST(Program, OptionsReachTheKernel) {
  const Device device = test::open_device();
  for (const int value : {3, -4}) {
    const auto options = BuildOptions().define("VALUE", value);
    EXPECT_EQ(run_constant(Program::from_text(device, "constant.cl", kConstant, options)), value);
  }
}

TEST(Program, IsBuiltOncePerDevice) {
  const Device device = test::open_device();
  const auto build = [](const Device& on, int value) {
    return Program::from_text(on, "constant.cl", kConstant, BuildOptions().define("VALUE", value));
  };
  EXPECT_EQ(build(device, 1).origin(), ProgramOrigin::kCompiled);
  EXPECT_EQ(build(device, 1).origin(), ProgramOrigin::kMemory);
  EXPECT_EQ(build(device, 2).origin(), ProgramOrigin::kCompiled);
  EXPECT_EQ(build(test::open_device(), 1).origin(), ProgramOrigin::kCompiled);
  // What the text doesn't name makes no other program.
  const auto more = BuildOptions().define("VALUE", 1).define("UNNAMED", 1);
  EXPECT_EQ(Program::from_text(device, "constant.cl", kConstant, more).origin(), ProgramOrigin::kMemory);
  EXPECT_EQ(build(device, 1).kernel_names(), std::vector<std::string>{"constant_value"});
  EXPECT_EQ(&build(device, 1).state(), &build(device, 1).state());
}

TEST(Program, DoubleNeedsFp64) {
  const Device device = test::open_device();
  const auto build = [&] {
    return Program::from_text(
        device, "k.cl", "__kernel void k(__global int* o) {}", BuildOptions().real(Precision::kDouble));
  };
  if (device.info().fp64) {
    EXPECT_EQ(build().precision(), Precision::kDouble);
  } else {
    EXPECT_TRUE(contains(error_of(ErrorKind::kDevice, [&] { (void)build(); }), {"k.cl", "fp64"}));
  }
}

}  // namespace
}  // namespace simuli
