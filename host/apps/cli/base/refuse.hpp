#pragma once
// How an option is refused: in one line, with what was found and what is allowed.
#include <string_view>

namespace simuli::cli {

/// Throws Error{kUsage} reading "OPTION: found FOUND, allowed ALLOWED".
[[noreturn]] void throw_usage_error(std::string_view option,
                                    std::string_view found,
                                    std::string_view allowed);
/// The same of an option's value, which stands in quotes.
[[noreturn]] void refuse(std::string_view option, std::string_view value, std::string_view allowed);

}  // namespace simuli::cli
