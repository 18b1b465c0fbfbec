#include "host/core/base/error.hpp"

#include <fmt/format.h>

#include "host/core/base/one_line.hpp"

namespace simuli {
namespace {

/// Longest part of a message, because parts may quote a file.
constexpr std::size_t kLongestPart = 1000;

std::string part_of_message(std::string_view text) {
  return std::string(text.substr(0, kLongestPart)) + (text.size() > kLongestPart ? "..." : "");
}

[[noreturn]] void throw_found(ErrorKind kind,
                              std::string_view file,
                              std::string_view field,
                              std::string_view found,
                              std::string_view allowed) {
  throw Error(kind,
              fmt::format("{}: {}: found {}, allowed {}",
                          part_of_message(file),
                          part_of_message(field),
                          part_of_message(found),
                          part_of_message(allowed)));
}

}  // namespace

Error::Error(ErrorKind kind, const std::string& message)
    : std::runtime_error(kind == ErrorKind::kKernel ? message : on_one_line(message)), kind_(kind) {}

void throw_input_error(std::string_view file,
                       std::string_view field,
                       std::string_view found,
                       std::string_view allowed) {
  throw_found(ErrorKind::kInput, file, field, found, allowed);
}

void throw_nothing_left(std::string_view file,
                        std::string_view field,
                        std::string_view found,
                        std::string_view allowed) {
  throw_found(ErrorKind::kNothing, file, field, found, allowed);
}

}  // namespace simuli
