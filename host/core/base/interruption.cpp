#include "host/core/base/interruption.hpp"

#include <utility>

namespace simuli {
namespace {

thread_local const std::function<void()>* requested = nullptr;

}  // namespace

Interruption::Interruption(const std::function<void()>& check) : before_(std::exchange(requested, &check)) {}

Interruption::~Interruption() { requested = before_; }

void Interruption::ask() {
  if (is_on()) (*requested)();
}
bool Interruption::is_on() { return requested != nullptr; }

}  // namespace simuli
