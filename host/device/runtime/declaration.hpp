#pragma once
// What kernel text says of its kernels' arguments: their names are the host's names for them, and drivers may
// have lost them (programs from a stored binary).
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

enum class ArgumentSpace { kValue, kGlobal, kLocal };

/// One argument of a kernel as it is declared.
struct ArgumentDeclaration {
  std::string name;
  std::string type;  // "real*", "FrameParams", "uint": qualifiers and spaces are gone
  ArgumentSpace space = ArgumentSpace::kValue;
  bool is_const = false;  // what a pointer points to
};
using KernelDeclaration = std::vector<ArgumentDeclaration>;

/// The kernels of `text` (expanded, macros excepted) by name. Argument lists made by macros are not
/// understood. Error{kKernel} for a kernel that is declared twice.
[[nodiscard]] std::map<std::string, KernelDeclaration> kernel_declarations(std::string_view text);

}  // namespace simuli
