#include "host/device/runtime/kernel.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "host/core/base/interruption.hpp"
#include "host/device/runtime/cl_error.hpp"
#include "host/device/runtime/device_state.hpp"

namespace simuli {

using detail::PassedType;

std::string Range::text() const {
  if (dimensions_ == 0) return "any";
  std::string text = std::to_string(size_[0]);
  for (std::uint32_t i = 1; i < dimensions_; ++i) text += " x " + std::to_string(size_[i]);
  return text;
}

namespace {

struct TypeAlias {
  std::string_view name;
  std::string_view type;
};
// Kernel texts and drivers may name a scalar by its typedef; these are the typedefs of cl/shared.
constexpr std::array kAliases = {
    TypeAlias{"sim_f32", "float"},
    TypeAlias{"sim_i32", "int"},
    TypeAlias{"sim_u32", "uint"},
    TypeAlias{"unsigned int", "uint"},
    TypeAlias{"unsigned char", "uchar"},
    TypeAlias{"unsigned short", "ushort"},
    TypeAlias{"unsigned long", "ulong"},
};

// Normalises a type for comparison: "struct Key *" -> "Key*", "real*" -> "double*".
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

// Checks the parsed declaration against the driver's argument info.
void compare_with_driver(const cl::Kernel& kernel,
                         const std::string& name,
                         const KernelDeclaration& declaration,
                         Precision precision) {
  const auto count = kernel.getInfo<CL_KERNEL_NUM_ARGS>();
  if (count != declaration.size()) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: it has {} arguments, its text declares {}", name, count, declaration.size()));
  }
  for (cl_uint i = 0; i < count; ++i) {
    const ArgumentDeclaration& text = declaration[i];
    std::string type;
    try {
      type = canonical(kernel.getArgInfo<CL_KERNEL_ARG_TYPE_NAME>(i), precision);
    } catch (const cl::Error& error) {
      // Drivers may have no argument info, for instance for programs from a binary.
      if (error.err() == CL_KERNEL_ARG_INFO_NOT_AVAILABLE) return;
      throw;
    }
    const std::string declared = canonical(text.type, precision);
    if (type == declared) continue;
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: argument {} is {}, its text declares {}", name, text.name, type, declared));
  }
}

}  // namespace

void Kernel::Release::operator()(_cl_kernel* kernel) const noexcept {
  if (!Device::is_forked()) clReleaseKernel(kernel);
}

Kernel::Kernel(const Program& program, std::string name) : program_(program), name_(std::move(name)) {
  const auto names = program.kernel_names();
  if (std::find(names.begin(), names.end(), name_) == names.end()) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {} is not in {}, which has: {}", name_, program.path(), fmt::join(names, ", ")));
  }
  const auto& declarations = program.state().declarations;
  const auto found = declarations.find(name_);
  if (found == declarations.end()) {
    throw Error(ErrorKind::kKernel,
                fmt::format("kernel {}: the text of {} does not declare it", name_, program.path()));
  }
  declaration_ = &found->second;
  const auto context = [&] { return "creating kernel " + name_; };
  cl_call(ErrorKind::kKernel, context, [&] {
    const cl::Kernel kernel(program.state().program, name_.c_str());
    compare_with_driver(kernel, name_, *declaration_, program.precision());
    clRetainKernel(kernel());
    kernel_.reset(kernel());
  });
}

std::uint32_t Kernel::find_slot(const char* name, const PassedType& type, bool offered) const {
  const auto found = std::find_if(declaration_->begin(),
                                  declaration_->end(),
                                  [&](const ArgumentDeclaration& argument) { return argument.name == name; });
  if (found == declaration_->end()) {
    if (offered) return kUnused;
    std::vector<std::string> names;
    for (const ArgumentDeclaration& argument : *declaration_) names.push_back(argument.name);
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: there is no argument {} among {}", name_, name, fmt::join(names, ", ")));
  }
  const auto refuse = [&](std::string_view declared, std::string_view passed) {
    throw Error(
        ErrorKind::kKernel,
        fmt::format("kernel {}: argument {} is {}, the host passes {}", name_, name, declared, passed));
  };
  if (found->space != type.space) refuse(space_name(found->space), space_name(type.space));
  const std::string declared = canonical(found->type, program_.precision());
  std::string passed(type.element);
  if (type.space == ArgumentSpace::kGlobal) passed += '*';
  passed = type.space == ArgumentSpace::kLocal ? declared : canonical(passed, program_.precision());
  if (declared != passed) refuse(declared, passed);
  const bool is_double = program_.precision() == Precision::kDouble;
  if (type.real_bytes != 0 && type.real_bytes != (is_double ? sizeof(double) : sizeof(float))) {
    refuse(declared + (is_double ? " of double" : " of float"), is_double ? "float" : "double");
  }
  if (type.is_const && !found->is_const) refuse(declared, "const " + passed);
  return static_cast<std::uint32_t>(found - declaration_->begin());
}

std::uint32_t Kernel::slot_of(const char* name, const PassedType& type, bool offered) {
  if (at_ < slots_.size() && slots_[at_].name == name && slots_[at_].type == &type) {
    return slots_[at_++].index;
  }
  // The argument list differs from the last launch.
  is_complete_ = false;
  slots_.resize(at_);
  const std::uint32_t index = find_slot(name, type, offered);
  slots_.push_back({name, &type, index});
  ++at_;
  return index;
}

void Kernel::need_all() const {
  std::vector<int> bound(declaration_->size(), 0);
  for (const ArgumentSlot& slot : slots_) {
    if (slot.index != kUnused) ++bound[slot.index];
  }
  for (std::size_t i = 0; i < bound.size(); ++i) {
    if (bound[i] == 1) continue;
    throw Error(ErrorKind::kKernel,
                fmt::format("kernel {}: argument {} is {}",
                            name_,
                            (*declaration_)[i].name,
                            bound[i] == 0 ? "not bound" : "bound twice"));
  }
}

void Kernel::set(std::uint32_t index, std::size_t bytes, const void* value) {
  const cl_int code = clSetKernelArg(kernel_.get(), index, bytes, value);
  if (code == CL_SUCCESS) return;
  throw_cl_error(
      ErrorKind::kKernel,
      cl::Error(code, "clSetKernelArg"),
      fmt::format("argument {} of kernel {}, {} bytes", (*declaration_)[index].name, name_, bytes));
}

void Kernel::set_memory(std::uint32_t index, const detail::Memory& memory) {
  if (memory.device().state().context() != program_.device().state().context()) {
    throw Error(ErrorKind::kInternal,
                fmt::format("kernel {}: argument {}, buffer {}, is on another device",
                            name_,
                            (*declaration_)[index].name,
                            memory.name()));
  }
  const cl_mem handle = memory.handle();
  set(index, sizeof(handle), &handle);
}

void Kernel::offer(const char* name, const PassedType& type, const detail::Memory& memory) {
  const std::uint32_t index = slot_of(name, type, true);
  if (index != kUnused) set_memory(index, memory);
}

void Kernel::bind(const Binding& binding) {
  if (binding.offer_ != nullptr) {
    binding.offer_(binding.group_, *this);
    return;
  }
  const std::uint32_t index = slot_of(binding.name_, *binding.type_, false);
  if (binding.memory_ != nullptr) {
    set_memory(index, *binding.memory_);
  } else if (binding.type_ == &detail::kPassedLocal) {
    // OpenCL does not accept an empty local argument.
    set(index, std::max<std::size_t>(binding.bytes_, 1), nullptr);
  } else if (binding.type_ != &detail::kPassedReal) {
    set(index, binding.bytes_, binding.value_.data());
  } else if (program_.precision() == Precision::kDouble) {
    set(index, sizeof(binding.real_), &binding.real_);
  } else {
    const auto narrow = static_cast<float>(binding.real_);
    set(index, sizeof(narrow), &narrow);
  }
}

void Kernel::run(const Range& global, const Range& local, std::initializer_list<Binding> arguments) {
  if (global.empty()) return;
  need_own_process();
  Interruption::ask();
  at_ = 0;
  for (const Binding& binding : arguments) bind(binding);
  if (!is_complete_ || at_ != slots_.size()) {
    is_complete_ = false;
    slots_.resize(at_);
    need_all();
    is_complete_ = true;
  }
  enqueue(global, local);
}

void Kernel::run_over(std::size_t count, std::initializer_list<Binding> arguments) {
  if (group_ == 0) {
    // GPU waves have 32 or 64 work-items; CPUs run best with few groups.
    const std::size_t usual = program_.device().info().is_cpu ? 32 : 64;
    group_ = std::min(usual, max_local_size());
  }
  run(round_up(count, group_), group_, arguments);
}

void Kernel::enqueue(const Range& global, const Range& local) {
  const Device& on = program_.device();
  const bool timed = on.profile().enabled();
  cl_event event = nullptr;
  const cl_int code = clEnqueueNDRangeKernel(on.state().queue(),
                                             kernel_.get(),
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

std::size_t Kernel::max_local_size() const {
  return cl_call(
      ErrorKind::kKernel,
      [&] { return "asking about kernel " + name_; },
      [&] {
        return cl::Kernel(kernel_.get(), true)
            .getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(program_.device().state().device);
      });
}

}  // namespace simuli
