#pragma once
#include <string>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/device/runtime/cl.hpp"

namespace simuli {

/// Returns "CL_OUT_OF_RESOURCES" for -5; "unknown OpenCL code" for codes that the standard does not name.
[[nodiscard]] std::string cl_code_name(cl_int code);

/// Throws Error{kind} reading "CALL failed: CL_NAME (NUMBER), CONTEXT".
[[noreturn]] void throw_cl_error(ErrorKind kind, const cl::Error& error, const std::string& context);

/// Throws Error{kDevice} when Device::is_forked(). Every function that calls the driver calls this first.
void need_own_process();

/// Runs f and converts a cl::Error to Error{kind}. `context` is called only on errors, so that the usual path
/// formats nothing. Throws Error{kDevice} when Device::is_forked().
template <class Context, class F>
decltype(auto) cl_call(ErrorKind kind, Context&& context, F&& f) {
  need_own_process();
  try {
    return std::forward<F>(f)();
  } catch (const cl::Error& error) {
    throw_cl_error(kind, error, std::forward<Context>(context)());
  }
}

}  // namespace simuli
