#pragma once
// Edits of actors of a scene on the command line.
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Texts of the edits; applied in this order, independent of the order on the command line.
struct Edits {
  std::vector<std::string> add;        // SCENE:ACTOR[:NAME] or SPLAT:NAME
  std::vector<std::string> duplicate;  // ACTOR:NAME
  std::vector<std::string> mirror;     // ACTOR
  std::vector<std::string> resize;     // ACTOR:FACTOR
  std::vector<std::string> track;      // ACTOR:LOG[:ACTOR]
  std::vector<std::string> retime;     // ACTOR:RATE[:DELAY_S]
  std::vector<std::string> move;       // ACTOR:FORWARD_M,LEFT_M,UP_M
  std::vector<std::string> turn;       // ACTOR:DEGREES
  std::vector<std::string> classes;    // ACTOR:CLASS
  std::vector<std::string> remove;     // ACTOR
};

/// Parses "X,Y,Z,ROLL,PITCH,YAW" in m and degrees. Throws Error{kUsage} with the name `option` for other
/// texts.
[[nodiscard]] Mounting parse_mounting(const char* option, const std::string& text);

/// Calls read_scene() and prints a note to stderr with the number of invalid particles left out of a splat
/// file.
[[nodiscard]] SceneFile read_scene_and_report(const std::filesystem::path& path);

void add_edit_options(Command sub, Edits& edits);
/// Returns one text per edit, in the order of application: "--remove car".
[[nodiscard]] std::vector<std::string> lines_of(const Edits& edits);
/// Returns the original actor of each duplicated actor, by the copy's name.
[[nodiscard]] ActorCopies copies_of(const Edits& edits);
/// Throws Error{kUsage} for an incomplete edit, Error{kInput} for an unreadable scene or log.
void apply(const Edits& edits, SceneFile& scene);
/// Returns world_from_base for added splats: the first ego position with the rig's heading, levelled.
[[nodiscard]] Pose standing_pose(const Trajectory& world_from_rig);

}  // namespace simuli::cli
