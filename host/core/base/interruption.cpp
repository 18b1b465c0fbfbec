#include "host/core/base/interruption.hpp"

#include <utility>

namespace simuli {
namespace {

thread_local const std::function<void()>* asked = nullptr;

}  // namespace

Interruption::Interruption(const std::function<void()>& check) : before_(std::exchange(asked, &check)) {}

Interruption::~Interruption() { asked = before_; }

void Interruption::ask() {
  if (is_on()) (*asked)();
}
bool Interruption::is_on() { return asked != nullptr; }

}  // namespace simuli
