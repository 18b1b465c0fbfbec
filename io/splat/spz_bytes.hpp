#pragma once
// SPZ data without a file and without a conversion of axes, for other formats that contain it.
#include <string>

#include "io/splat/splat_file.hpp"

namespace simuli {

/// read_spz() without a rotation.
[[nodiscard]] GaussianSet set_of_spz(std::string bytes,
                                     const std::string& file,
                                     SplatReport* report = nullptr);
/// write_spz() to bytes, without a rotation.
[[nodiscard]] std::string spz_of(const GaussianSet& set, const std::string& file);

}  // namespace simuli
