#pragma once

namespace simuli {

/// What `real` is in kernel text. kDouble needs a device with fp64 (DeviceInfo::fp64).
enum class Precision { kFloat, kDouble };

}  // namespace simuli
