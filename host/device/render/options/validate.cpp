#include "host/device/render/options/validate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"

namespace simuli {

void validate(const RenderOptions& options) {
  check_fields(options);
#if !SIMULI_PAPER
  if (options.extent == Extent::kUnscented) {
    throw Error(ErrorKind::kUsage,
                "render.extent: found unscented, allowed exact in builds without SIMULI_PAPER");
  }
#endif
  if (options.projection != Projection::kUnscented && options.extent == Extent::kExact) {
    throw Error(
        ErrorKind::kUsage,
        "render.projection: found another value than unscented with render.extent=exact, which does not use "
        "it, allowed with render.extent=unscented");
  }
}

void need_numbers(std::span<const float> values, float largest, const char* what) {
  const auto bad =
      std::find_if(values.begin(), values.end(), [&](float v) { return !(std::abs(v) <= largest); });
  if (bad == values.end()) return;
  throw Error(
      ErrorKind::kNumeric,
      fmt::format(
          "{}: found {} as value {}, allowed numbers up to {:g}", what, *bad, bad - values.begin(), largest));
}

}  // namespace simuli
