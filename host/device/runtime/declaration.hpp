#pragma once
// Parses the declarations of kernels from their text. The host binds arguments by these names, and drivers lose
// them for programs loaded from a binary.
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

enum class ArgumentSpace { kValue, kGlobal, kLocal };

/// One argument of a kernel declaration.
struct ArgumentDeclaration {
  std::string name;
  std::string type;  // "real*", "FrameParams", "uint": without qualifiers and spaces
  ArgumentSpace space = ArgumentSpace::kValue;
  bool is_const = false;  // the pointer's target type
};
using KernelDeclaration = std::vector<ArgumentDeclaration>;

/// The kernels of `text` (expanded, macros excepted) by name. Argument lists that macros
/// generate are not parsed. Throws Error{kKernel} for a kernel that is declared twice.
[[nodiscard]] std::map<std::string, KernelDeclaration> kernel_declarations(std::string_view text);

}  // namespace simuli
