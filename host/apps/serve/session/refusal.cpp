#include "host/apps/serve/session/refusal.hpp"

#include <fmt/format.h>
#include <new>

#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"

namespace simuli::serve {
namespace {

RefusalKind kind_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kUsage:
    case ErrorKind::kInput:
    case ErrorKind::kNothing:
    case ErrorKind::kNumeric:
      return RefusalKind::kInvalid;
    case ErrorKind::kDevice:
      return RefusalKind::kExhausted;
    case ErrorKind::kKernel:
    case ErrorKind::kInternal:
      break;
  }
  return RefusalKind::kInternal;
}

/// Shortens a message: statuses are sent in a header, and clients refuse long ones.
std::string short_line(const std::string& message) {
  constexpr std::size_t kMost = 1000;
  std::string line = on_one_line(message);
  if (line.size() <= kMost) return line;
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0U) == 0x80U)
    --end;  // avoid splitting a character
  line.resize(end);
  return line + "...";
}

}  // namespace

Refusal::Refusal(RefusalKind kind, const std::string& message)
    : std::runtime_error(short_line(message)), kind_(kind) {}

void refuse(const std::string& field, const std::string& found, const std::string& allowed) {
  throw Refusal(RefusalKind::kInvalid, fmt::format("{}: found {}, allowed {}", field, found, allowed));
}

Refusal refusal_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Refusal& refusal) {
    return refusal;
  } catch (const Error& of_library) {
    return {kind_of(of_library.kind()), of_library.what()};
  } catch (const std::bad_alloc&) {
    return {RefusalKind::kExhausted, "out of memory"};
  } catch (const std::exception& other) {
    return {RefusalKind::kInternal, fmt::format("internal error: {}", other.what())};
  }
}

}  // namespace simuli::serve
