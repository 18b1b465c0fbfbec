#pragma once
#include <string>

namespace simuli {

/// Who else names classes: CARLA's NuRec client ("automobile", "heavy_truck", "bus", "trailer", "rider",
/// "person"), KITTI ("Car", "Van", "Truck", "Pedestrian", "Cyclist", "Tram") and nuScenes ("vehicle.car", ...).
enum class LabelNames { kNuRec, kKitti, kNuscenes };

/// An actor's kind, which is free text, by the name that it has there. As it is where none of its words says
/// which.
[[nodiscard]] std::string label_class_of(const std::string& kind, LabelNames names = LabelNames::kNuRec);
/// Whether there is such a name.
[[nodiscard]] bool has_label_class(const std::string& kind, LabelNames names);

}  // namespace simuli
