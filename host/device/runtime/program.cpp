#include "host/device/runtime/program.hpp"

#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/core/base/activity.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device_state.hpp"
#include "host/device/runtime/disk_cache.hpp"
#include "host/device/runtime/source.hpp"

namespace simuli {

namespace {

std::string build_log(const cl::Program& program, const cl::Device& device) {
  try {
    return program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device);
  } catch (const cl::Error&) {
    return "(the driver gives no build log)";
  }
}

cl::Program compile(const Device& device,
                    const std::string& shown,
                    const std::string& source,
                    const std::string& options) {
  const auto context = [&] { return fmt::format("building {} with options {}", shown, options); };
  auto program =
      cl_call(ErrorKind::kKernel, context, [&] { return cl::Program(device.state().context, source); });
  try {
    // clBuildProgram rather than compile and link, because drivers cache this call.
    program.build({device.state().device}, options.c_str());
  } catch (const cl::Error& error) {
    throw Error(ErrorKind::kKernel,
                fmt::format("{} does not build: {} ({}), options {}\n{}",
                            shown,
                            cl_code_name(error.err()),
                            error.err(),
                            options,
                            build_log(program, device.state().device)));
  }
  return program;
}

// A stored binary that the driver rejects is not an error: the caller compiles instead.
std::optional<cl::Program> from_binary(const Device& device,
                                       const ProgramBinary& binary,
                                       const std::string& options) {
  try {
    cl::Program program(device.state().context, {device.state().device}, cl::Program::Binaries{binary});
    program.build({device.state().device}, options.c_str());
    std::vector<cl::Kernel> kernels;
    program.createKernels(&kernels);
    return program;
  } catch (const cl::Error&) {
    return std::nullopt;
  }
}

// Returns no value when the driver does not return its binary; only the cache is lost then.
std::optional<ProgramBinary> binary_of(const cl::Program& program, const cl::Device& device) {
  try {
    const auto devices = program.getInfo<CL_PROGRAM_DEVICES>();
    auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    for (std::size_t i = 0; i < devices.size() && i < binaries.size(); ++i) {
      if (devices[i]() == device()) return std::move(binaries[i]);
    }
  } catch (const cl::Error&) {
    return std::nullopt;
  }
  return std::nullopt;
}

std::vector<std::string> names_of(const cl::Program& program) {
  std::vector<cl::Kernel> kernels;
  // Creating all kernels makes lazy drivers compile, so that the stored binary is complete.
  cl::Program(program).createKernels(&kernels);
  std::vector<std::string> names;
  for (const cl::Kernel& kernel : kernels) {
    std::string name = kernel.getInfo<CL_KERNEL_FUNCTION_NAME>();
    while (!name.empty() && name.back() == '\0') name.pop_back();
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

Program::Program(const Device& device, const Expanded& expanded, const BuildOptions& options)
    : device_(device) {
  if (options.precision() == Precision::kDouble && !device.info().fp64) {
    throw Error(ErrorKind::kDevice,
                fmt::format("{} in double precision: {} has no fp64", expanded.shown, device.info().label()));
  }
  const std::string text = options.named_in(expanded.source).text();
  const std::string key = program_key(device.info(), text, expanded.source);
  auto& programs = device.state().programs;
  if (const auto found = programs.find(key); found != programs.end()) {
    state_ = found->second;
    origin_ = ProgramOrigin::kMemory;
    return;
  }
  auto state = std::make_shared<detail::ProgramState>();
  state->path = expanded.shown;
  state->options = text;
  state->precision = options.precision();
  std::optional<cl::Program> stored;
  if (const auto binary = load_binary(key)) stored = from_binary(device, *binary, text);
  origin_ = stored ? ProgramOrigin::kDisk : ProgramOrigin::kCompiled;
  std::optional<Activity> compiling;  // includes the creation of kernels, when lazy drivers compile
  if (!stored) compiling.emplace("compiling " + expanded.shown);
  state->program = stored ? *stored : compile(device, expanded.shown, expanded.source, text);
  state->kernel_names = cl_call(
      ErrorKind::kKernel,
      [&] { return "listing the kernels of " + expanded.shown; },
      [&] { return names_of(state->program); });
  driver_has_built();
  state->declarations = kernel_declarations(expanded.source);
  if (!stored) {
    if (const auto binary = binary_of(state->program, device.state().device)) save_binary(key, *binary);
  }
  programs.emplace(key, state);
  state_ = std::move(state);
}

Program::Program(const Device& device, std::string_view path, const BuildOptions& options)
    : Program(device, Expanded{"cl/" + std::string(path), expand_file(path)}, options) {}

Program Program::from_text(const Device& device,
                           std::string_view name,
                           std::string_view text,
                           const BuildOptions& options) {
  return Program(device, Expanded{std::string(name), expand_text(name, text)}, options);
}

Precision Program::precision() const { return state_->precision; }
const std::string& Program::path() const { return state_->path; }
std::vector<std::string> Program::kernel_names() const { return state_->kernel_names; }

std::vector<BuiltProgram> built_programs(const Device& device) {
  std::vector<BuiltProgram> out;
  for (const auto& [key, program] : device.state().programs) out.push_back({program->path, program->options});
  return out;
}

}  // namespace simuli
