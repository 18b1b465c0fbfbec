#pragma once
// Reasons for refused requests.
#include <exception>
#include <stdexcept>
#include <string>

namespace simuli::serve {

/// Values equal gRPC's status codes.
enum class RefusalKind : int {
  kCancelled = 1,
  kInvalid = 3,
  kNotFound = 5,
  kDenied = 7,
  kExhausted = 8,
  kPrecondition = 9,
  kOutOfRange = 11,
  kUnimplemented = 12,
  kInternal = 13,
};

/// An error message to a client: one line.
class Refusal : public std::runtime_error {
 public:
  Refusal(RefusalKind kind, const std::string& message);
  [[nodiscard]] RefusalKind kind() const noexcept { return kind_; }

 private:
  RefusalKind kind_;
};

/// Throws Refusal{kInvalid} with "FIELD: found FOUND, allowed ALLOWED".
[[noreturn]] void refuse(const std::string& field, const std::string& found, const std::string& allowed);

/// Converts an exception of a request to a refusal: errors caused by the request's values are kInvalid, a
/// device or host without memory is kExhausted, all others are kInternal.
[[nodiscard]] Refusal refusal_of(const std::exception_ptr& error);

}  // namespace simuli::serve
