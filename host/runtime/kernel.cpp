#include "host/runtime/kernel.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/runtime/cl_error.hpp"
#include "host/runtime/device_state.hpp"

namespace simuli {

std::string Range::text() const {
  if (dimensions_ == 0) return "any";
  std::string text = std::to_string(size_[0]);
  for (cl_uint i = 1; i < dimensions_; ++i) text += " x " + std::to_string(size_[i]);
  return text;
}

namespace detail {
namespace {

struct TypeAlias {
  std::string_view name;
  std::string_view type;
};
// Drivers give an argument's type as written, typedef or not; these are the scalars of cl/shared.
constexpr std::array kAliases = {
    TypeAlias{"sim_f32", "float"},
    TypeAlias{"sim_i32", "int"},
    TypeAlias{"sim_u32", "uint"},
    TypeAlias{"unsigned int", "uint"},
    TypeAlias{"unsigned char", "uchar"},
    TypeAlias{"unsigned short", "ushort"},
    TypeAlias{"unsigned long", "ulong"},
};

// "struct Key *" -> "Key*", "real*" -> "double*": one spelling to compare.
std::string canonical(std::string type, Precision precision) {
  while (!type.empty() && type.back() == '\0') type.pop_back();
  std::string stars;
  while (!type.empty() && (type.back() == '*' || type.back() == ' ')) {
    if (type.back() == '*') stars += '*';
    type.pop_back();
  }
  constexpr std::string_view kStruct = "struct ";
  if (type.starts_with(kStruct)) type.erase(0, kStruct.size());
  if (type == "real") type = precision == Precision::kDouble ? "double" : "float";
  for (const TypeAlias& alias : kAliases) {
    if (type == alias.name) {
      type = alias.type;
      break;
    }
  }
  return type + stars;
}

ArgumentSpace space_of(cl_kernel_arg_address_qualifier qualifier) {
  switch (qualifier) {
    case CL_KERNEL_ARG_ADDRESS_GLOBAL:
    case CL_KERNEL_ARG_ADDRESS_CONSTANT:
      return ArgumentSpace::kGlobal;
    case CL_KERNEL_ARG_ADDRESS_LOCAL:
      return ArgumentSpace::kLocal;
    default:
      return ArgumentSpace::kValue;
  }
}

std::string_view space_name(ArgumentSpace space) {
  switch (space) {
    case ArgumentSpace::kGlobal:
      return "global memory";
    case ArgumentSpace::kLocal:
      return "local memory";
    case ArgumentSpace::kValue:
      break;
  }
  return "a value";
}

void check_argument(const cl::Kernel& kernel,
                    const std::string& name,
                    cl_uint index,
                    const ArgumentSpec& spec,
                    Precision precision) {
  std::string declared;
  ArgumentSpace space{};
  bool is_const = false;
  try {
    declared = canonical(kernel.getArgInfo<CL_KERNEL_ARG_TYPE_NAME>(index), precision);
    const auto address = kernel.getArgInfo<CL_KERNEL_ARG_ADDRESS_QUALIFIER>(index);
    space = space_of(address);
    is_const = address == CL_KERNEL_ARG_ADDRESS_CONSTANT ||
               (kernel.getArgInfo<CL_KERNEL_ARG_TYPE_QUALIFIER>(index) & CL_KERNEL_ARG_TYPE_CONST) != 0;
  } catch (const cl::Error& error) {
    // Drivers may give none, for instance for programs from a binary; the number of arguments is checked.
    if (error.err() == CL_KERNEL_ARG_INFO_NOT_AVAILABLE) return;
    throw_cl_error(ErrorKind::kKernel, error, fmt::format("asking about argument {} of {}", index, name));
  }
  const std::string passed = spec.type.empty() ? declared : canonical(spec.type, precision);
  if (declared != passed) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: argument {} is {}, the host passes {}", name, index, declared, passed));
  }
  if (space != spec.space) {
    throw Error(ErrorKind::kKernel,
                fmt::format("kernel {}: argument {} is {}, the host passes {}",
                            name,
                            index,
                            space_name(space),
                            space_name(spec.space)));
  }
  if (spec.is_const && !is_const) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: argument {} is {}, the host passes const {}", name, index, declared, passed));
  }
}

}  // namespace

KernelCore::KernelCore(const Program& program, std::string name, const std::vector<ArgumentSpec>& arguments)
    : program_(program), name_(std::move(name)) {
  const auto names = program.kernel_names();
  if (std::find(names.begin(), names.end(), name_) == names.end()) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {} is not in {}, which has: {}", name_, program.path(), fmt::join(names, ", ")));
  }
  const auto context = [&] { return "creating kernel " + name_; };
  cl_call(ErrorKind::kKernel, context, [&] {
    kernel_ = cl::Kernel(program.handle(), name_.c_str());
    const auto count = kernel_.getInfo<CL_KERNEL_NUM_ARGS>();
    if (count != arguments.size()) {
      throw Error(
          ErrorKind::kKernel,
          fmt::format("kernel {}: it has {} arguments, the host passes {}", name_, count, arguments.size()));
    }
  });
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    check_argument(kernel_, name_, static_cast<cl_uint>(i), arguments[i], program.precision());
  }
}

void KernelCore::set_value(cl_uint index, const void* value, std::size_t bytes) {
  cl_call(
      ErrorKind::kKernel,
      [&] { return fmt::format("argument {} of kernel {}, {} bytes", index, name_, bytes); },
      [&] { kernel_.setArg(index, bytes, value); });
}

void KernelCore::set_real(cl_uint index, double value) {
  if (program_.precision() == Precision::kDouble) {
    set_value(index, &value, sizeof(value));
  } else {
    const auto narrow = static_cast<float>(value);
    set_value(index, &narrow, sizeof(narrow));
  }
}

void KernelCore::set_local(cl_uint index, std::size_t bytes) {
  // OpenCL refuses an empty local argument.
  set_value(index, nullptr, std::max<std::size_t>(bytes, 1));
}

void KernelCore::set_memory(cl_uint index, const Memory& memory) {
  if (memory.device().state().context() != program_.device().state().context()) {
    throw Error(
        ErrorKind::kInternal,
        fmt::format("kernel {}: argument {}, buffer {}, is on another device", name_, index, memory.name()));
  }
  const cl_mem handle = memory.handle()();
  set_value(index, &handle, sizeof(handle));
}

void KernelCore::set_real_buffer(cl_uint index, const RealBuffer& buffer) {
  if (buffer.precision() != program_.precision()) {
    throw Error(
        ErrorKind::kInternal,
        fmt::format(
            "kernel {}: argument {}, buffer {}, is of the other precision", name_, index, buffer.name()));
  }
  set_memory(index, buffer.memory());
}

void KernelCore::run(const Range& global, const Range& local) {
  const Device& on = program_.device();
  const bool timed = on.profile().enabled();
  cl_event event = nullptr;
  // The C call: the binding's NDRange has no three-way choice at run time.
  const cl_int code = clEnqueueNDRangeKernel(on.state().queue(),
                                             kernel_(),
                                             global.dimensions(),
                                             nullptr,
                                             global.data(),
                                             local.data(),
                                             0,
                                             nullptr,
                                             timed ? &event : nullptr);
  if (code != CL_SUCCESS) {
    throw_cl_error(
        ErrorKind::kKernel,
        cl::Error(code, "clEnqueueNDRangeKernel"),
        fmt::format("kernel {}, global size {}, local size {}", name_, global.text(), local.text()));
  }
  if (timed) on.profile().record(name_, event);
}

std::size_t KernelCore::max_local_size() const {
  return cl_call(
      ErrorKind::kKernel,
      [&] { return "asking about kernel " + name_; },
      [&] { return kernel_.getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(device().state().device); });
}

}  // namespace detail
}  // namespace simuli
