#pragma once
#include <string>

namespace simuli {

/// Class names of CARLA's NuRec client ("automobile", "heavy_truck", "bus", "trailer", "rider", "person"),
/// KITTI ("Car", "Van", "Truck", "Pedestrian", "Cyclist", "Tram") and nuScenes ("vehicle.car", ...).
enum class LabelNames { kNuRec, kKitti, kNuscenes };

/// Returns the class of an actor's kind, which is free text. Returns the kind unchanged if none of its words
/// determines a class.
[[nodiscard]] std::string label_class_of(const std::string& kind, LabelNames names = LabelNames::kNuRec);
/// Whether a class exists for the kind.
[[nodiscard]] bool has_label_class(const std::string& kind, LabelNames names);

}  // namespace simuli
