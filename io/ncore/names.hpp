#pragma once
// Names in NCore files, for io/ncore and io/import/ncore.
#include <string>

namespace simuli::ncore {

inline constexpr const char* kVersion = "v4";
inline constexpr const char* kComponentVersion = "v1";
inline constexpr const char* kRig = "rig";
inline constexpr const char* kWorld = "world";
inline constexpr const char* kOnly = "default";  // instance name of a component with a single instance
inline constexpr const char* kValidMask = "ray_bundle_returns_valid_mask_packed";

/// Key of this project's data in generic_meta_data, and prefix of its arrays in generic_data.
inline constexpr const char* kOurs = "simuli";
inline constexpr const char* kExactRay = "simuli_ray";
inline constexpr const char* kExactValues = "simuli_values";

/// Returns the group of a component with a single instance.
inline std::string component(const std::string& kind) { return kind + '/' + kOnly; }

}  // namespace simuli::ncore
