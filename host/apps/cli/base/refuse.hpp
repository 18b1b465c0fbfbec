#pragma once
// Rejects an option in one line that contains the found and the allowed value.
#include <string_view>

namespace simuli::cli {

/// Throws Error{kUsage} with the message "OPTION: found FOUND, allowed ALLOWED".
[[noreturn]] void throw_usage_error(std::string_view option,
                                    std::string_view found,
                                    std::string_view allowed);
/// The same for the value of an option, which is put in quotes.
[[noreturn]] void refuse(std::string_view option, std::string_view value, std::string_view allowed);

}  // namespace simuli::cli
