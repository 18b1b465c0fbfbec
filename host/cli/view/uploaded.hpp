#pragma once
// Files that pages send.
#include <string>

#include "host/scene/scene.hpp"

namespace simuli::cli {

/// The scene of a splat file of that name and with these bytes, which lies meanwhile in a folder of its own
/// that only this user sees. Error{kInput} as read_scene(), naming the file as the page does, and for names
/// of other files.
[[nodiscard]] Scene uploaded_scene(const std::string& name, const std::string& bytes);

}  // namespace simuli::cli
