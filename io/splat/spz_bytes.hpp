#pragma once
// SPZ without a file around it, in whatever axes: as other formats carry it.
#include <string>

#include "io/splat/splat_file.hpp"

namespace simuli {

/// As read_spz(), but nothing is turned.
[[nodiscard]] GaussianSet set_of_spz(std::string bytes,
                                     const std::string& file,
                                     SplatReport* report = nullptr);
/// As write_spz() writes it, but nothing is turned.
[[nodiscard]] std::string spz_of(const GaussianSet& set, const std::string& file);

}  // namespace simuli
