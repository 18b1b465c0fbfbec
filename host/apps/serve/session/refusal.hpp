#pragma once
// Why a request gets no answer.
#include <exception>
#include <stdexcept>
#include <string>

namespace simuli::serve {

/// The values are those of gRPC's status codes.
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

/// What a client is told: one line.
class Refusal : public std::runtime_error {
 public:
  Refusal(RefusalKind kind, const std::string& message);
  [[nodiscard]] RefusalKind kind() const noexcept { return kind_; }

 private:
  RefusalKind kind_;
};

/// Refusal{kInvalid} reading "FIELD: found FOUND, allowed ALLOWED".
[[noreturn]] void refuse(const std::string& field, const std::string& found, const std::string& allowed);

/// What a client is told of an error while its request was handled: what a request's numbers led to is
/// kInvalid, a device or host without memory kExhausted, and what is no fault of the request's kInternal.
[[nodiscard]] Refusal refusal_of(const std::exception_ptr& error);

}  // namespace simuli::serve
