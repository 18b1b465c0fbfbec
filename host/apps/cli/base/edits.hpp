#pragma once
// Edits of a scene's actors on the command line.
#include <map>
#include <string>
#include <vector>

#include "host/apps/cli/base/command.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// As given; applied in this order, whatever the order on the command line.
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

/// "X,Y,Z,ROLL,PITCH,YAW", m and degrees. Error{kUsage} naming `option` for anything else.
[[nodiscard]] Mounting parse_mounting(const char* option, const std::string& text);

/// read_scene(); a note on stderr says how many broken particles of a file of splats that left out.
[[nodiscard]] SceneFile read_scene_and_report(const std::filesystem::path& path);

void add_edit_options(Command sub, Edits& edits);
/// Each as it is given, in the order in which they are applied: "--remove car".
[[nodiscard]] std::vector<std::string> lines_of(const Edits& edits);
/// Whose copy each duplicated actor is, by its name.
[[nodiscard]] std::map<std::string, std::string> copies_of(const Edits& edits);
/// Error{kUsage} for an edit that says nothing, Error{kInput} for a scene or log that can't be read.
void apply(const Edits& edits, SceneFile& scene);
/// world_from_base of splats that are added: where the path begins, turned as the rig is there, upright.
[[nodiscard]] Pose standing_pose(const Trajectory& world_from_rig);

}  // namespace simuli::cli
