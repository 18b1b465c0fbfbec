#include "host/render/frame/variant.hpp"

namespace simuli {

BuildOptions Variant::options() const {
  BuildOptions options;
  // Only where there are any: programs of scenes without actors are the same as ever.
  if (actors) options.define("ACTORS", true).define("ACTOR_MOTION", actor_motion);
  options.real(precision)
      .define("SENSOR", sensor)
      .define("LENS", lens)
      .define("MOVING", moving)
      .define("ORIGINS", origins)
      .define("SH_DEGREE", sh_degree)
      .define("MEDIAN", median)
      .define("PROJECTION", projection)
      .define("V", shape.lanes);
  if (math == Math::kPrecise) options.define("MATH_PRECISE", true);
  if (sh_storage == ShStorage::kHalf) options.define("SH_HALF", true);
  return options;
}

BuildOptions Variant::tile_options() const {
  return options().define("NR", shape.vectors).define("LS", shape.work_items);
}

}  // namespace simuli
