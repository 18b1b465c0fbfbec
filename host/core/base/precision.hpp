#pragma once

namespace simuli {

/// Type of `real` in kernel text. kDouble needs a device with fp64 (DeviceInfo::fp64).
enum class Precision { kFloat, kDouble };

}  // namespace simuli
