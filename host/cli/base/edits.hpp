#pragma once
// Edits of a scene's actors on the command line.
#include <string>
#include <vector>

#include "host/cli/base/command.hpp"
#include "host/scene/scene.hpp"

namespace simuli::cli {

/// As given; applied in this order, whatever the order on the command line.
struct Edits {
  std::vector<std::string> add;        // SCENE:ACTOR[:NAME]
  std::vector<std::string> duplicate;  // ACTOR:NAME
  std::vector<std::string> resize;     // ACTOR:FACTOR
  std::vector<std::string> track;      // ACTOR:LOG[:ACTOR]
  std::vector<std::string> retime;     // ACTOR:RATE[:DELAY_S]
  std::vector<std::string> move;       // ACTOR:FORWARD_M,LEFT_M,UP_M
  std::vector<std::string> turn;       // ACTOR:DEGREES
  std::vector<std::string> remove;     // ACTOR
};

void add_edit_options(Command sub, Edits& edits);
/// Each as it is given, in the order in which they are applied: "--remove car".
[[nodiscard]] std::vector<std::string> lines_of(const Edits& edits);
/// Error{kUsage} for an edit that says nothing, Error{kInput} for a scene or log that can't be read.
void apply(const Edits& edits, Scene& scene);

}  // namespace simuli::cli
