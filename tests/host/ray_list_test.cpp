#include "host/core/sensors/ray_list.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace ray_list_test {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

RayList three_rays() {
  RayList list;
  list.name = "three";
  list.azimuth = {0.0, 0.5, -0.5};
  list.elevation = {0.1, 0.0, -0.2};
  list.time_fraction = {0.0, 0.5, 1.0};
  list.range_min = 0.2;
  list.range_max = 50.0;
  return list;
}

TEST(RayList, RaysStartWhereTheListSays) {
  RayList list = three_rays();
  EXPECT_EQ(list.ray_count(), 3U);
  EXPECT_EQ(list.ray_origin(1), Eigen::Vector3d(0, 0, 0));
  EXPECT_NEAR(std::asin(list.direction(0).z()), 0.1, 1e-12);
  list.origin = {{1, 2, 3}, {0, 0, 0}, {0, 0.1, 0}};
  EXPECT_EQ(list.ray_origin(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_NO_THROW(validate(list, "list.json"));
}

TEST(RayList, ValidateNamesTheFieldThatIsWrong) {
  EXPECT_NO_THROW(validate(three_rays(), "list.json"));
  const auto refused = [](const char* field, auto set) {
    RayList list = three_rays();
    set(list);
    expect_error(ErrorKind::kInput, fmt::format("list.json: ray list three: {}", field), [&] {
      validate(list, "list.json");
    });
  };
  refused("azimuth_rad: found 0 rays", [](RayList& l) { l.azimuth.clear(); });
  refused("elevation_rad: found 2 rays", [](RayList& l) { l.elevation.pop_back(); });
  refused("time_fraction: found 4 rays", [](RayList& l) { l.time_fraction.push_back(0.0); });
  refused("origin_m: found 1 rays", [](RayList& l) { l.origin.resize(1); });
  refused("azimuth_rad[1]", [](RayList& l) { l.azimuth[1] = kNan; });
  refused("elevation_rad[2]", [](RayList& l) { l.elevation[2] = 1.6; });
  refused("time_fraction[0]", [](RayList& l) { l.time_fraction[0] = -1.1; });
  refused("origin_m[2]", [](RayList& l) { l.origin = {{0, 0, 0}, {0, 0, 0}, {0, kNan, 0}}; });
  refused("range_min_m", [](RayList& l) { l.range_min = -1.0; });
  refused("range_max_m", [](RayList& l) { l.range_max = 0.2; });
  refused("beam_divergence_rad", [](RayList& l) { l.beam_divergence = 0.5; });
  refused("divergence_variance", [](RayList& l) { l.divergence_variance = kNan; });
}

}  // namespace ray_list_test
}  // namespace simuli
