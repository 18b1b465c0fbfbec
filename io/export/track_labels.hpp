#pragma once
#include <string>

namespace simuli {

/// An actor's kind, which is free text, by the name that CARLA's NuRec client knows it by: "automobile",
/// "heavy_truck", "bus", "trailer", "rider", "person". As it is where none of its words says which.
[[nodiscard]] std::string label_class_of(const std::string& kind);

}  // namespace simuli
