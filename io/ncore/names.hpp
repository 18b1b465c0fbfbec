#pragma once
// Names in NCore files. For io/ncore and io/import/ncore.
#include <string>

namespace simuli::ncore {

inline constexpr const char* kVersion = "v4";
inline constexpr const char* kComponentVersion = "v1";
inline constexpr const char* kRig = "rig";
inline constexpr const char* kWorld = "world";
inline constexpr const char* kOnly = "default";  // instance of a component that is there once
inline constexpr const char* kValidMask = "ray_bundle_returns_valid_mask_packed";

/// What is ours stands under this key of generic_meta_data; arrays of generic_data begin with it.
inline constexpr const char* kOurs = "simuli";
inline constexpr const char* kExactRay = "simuli_ray";
inline constexpr const char* kExactValues = "simuli_values";

/// Group of a component that is there once.
inline std::string component(const std::string& kind) { return kind + '/' + kOnly; }

}  // namespace simuli::ncore
