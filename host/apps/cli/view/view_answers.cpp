#include "host/apps/cli/view/view_answers.hpp"

#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

[[noreturn]] void need_scene(const char* what) {
  throw_usage_error(what, "a log", "a scene: simuli train LOG -o SCENE");
}

}  // namespace

std::string ViewAnswers::duplicate(const std::string&) { need_scene("duplicate"); }
std::string ViewAnswers::add(const std::string&, const std::string&, double) { need_scene("add"); }
std::string ViewAnswers::command(const ViewRequest&) const { need_scene("command"); }

}  // namespace simuli::cli
