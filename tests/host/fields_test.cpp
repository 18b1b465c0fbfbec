#include "host/core/base/fields.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

enum class Order { kRange, kPerRay };

struct Rates {
  double opacity = 0.1;
  double final_share = 0.5;
};
template <class F>
constexpr void visit_fields(Rates& o, F&& field) {
  field("rate.opacity", o.opacity, at_least(0.0), "per step");
  field("rate.final_share", o.final_share, above(0.0, 1.0), "at the end");
}

struct Options {
  Rates camera{.opacity = 0.3};
  Rates lidar;
  bool shell = true;
  Order order = Order::kPerRay;
  std::size_t cap = 7;
  int width = 0;
  int looks = 4;
  double internal = 0.0;
};
template <class F>
constexpr void visit_fields(Options& o, F&& field) {
  field.part("camera.", o.camera);
  field.part("lidar.", o.lidar);
  field("shell", o.shell, "far away");
  field.group("Blending");
  field("order",
        o.order,
        one_of("range", "per_ray"),
        "of what a ray meets: by the distance of particles from the sensor, or by where the ray itself "
        "meets them");
  field("cap", o.cap, at_least(0), "particles");
  field("width", o.width, zero_or(even(range(8, 7200))), "texels");
  field("looks", o.looks, range(0, 64), "of each point");
  field.internal(o.internal);
}

/// Has a member that its visitor does not visit.
struct Forgetful {
  int reported = 0;
  Rates rates;
  double forgotten = 0.0;
};
template <class F>
constexpr void visit_fields(Forgetful& o, F&& field) {
  field("told", o.reported, at_least(0), "");
  field.part("", o.rates);
}

// Fields::part() does not compile if this is false.
static_assert(kVisitsAllMembers<Rates> && kVisitsAllMembers<Options>);
static_assert(!kVisitsAllMembers<Forgetful>);

void expect_refused(const std::vector<std::string>& settings, const std::string& message) {
  Options options;
  expect_error(ErrorKind::kUsage, message, [&] { fields_of(options).apply(settings); });
}

TEST(Fields, AreSetByTheirKeys) {
  Options options;
  fields_of(options).apply({"camera.rate.opacity=0.25",
                            "lidar.rate.opacity=1e-3",
                            "shell=false",
                            "order=range",
                            "cap=18446744073709551615",
                            "width=8",
                            "looks=64"});
  EXPECT_EQ(options.camera.opacity, 0.25);
  EXPECT_EQ(options.lidar.opacity, 1e-3);
  EXPECT_FALSE(options.shell);
  EXPECT_EQ(options.order, Order::kRange);
  EXPECT_EQ(options.cap, std::numeric_limits<std::size_t>::max());
  EXPECT_EQ(options.width, 8);
  EXPECT_EQ(options.looks, 64);
}

TEST(Fields, RefusalsNameTheKeyWithWhatIsAllowed) {
  expect_refused({"camera.rate.opacity=-1"}, "--set camera.rate.opacity: found -1, allowed 0 or more");
  expect_refused({"lidar.rate.opacity=inf"}, "--set lidar.rate.opacity: found inf, allowed 0 or more");
  expect_refused({"lidar.rate.opacity=nan"}, "--set lidar.rate.opacity: found nan");
  expect_refused({"lidar.rate.opacity=fast"}, "--set lidar.rate.opacity: found \"fast\", allowed 0 or more");
  expect_refused({"camera.rate.final_share=0"},
                 "--set camera.rate.final_share: found 0, allowed above 0, at most 1");
  expect_refused({"shell=1"}, "--set shell: found 1, allowed true, false");
  expect_refused({"order=both"}, "--set order: found \"both\", allowed range, per_ray");
  expect_refused({"cap=-1"}, "--set cap: found -1, allowed 0 or more (whole)");
  expect_refused({"width=9"}, "--set width: found 9, allowed 0, or 8 to 7200 and even");
  expect_refused({"looks=1.5"}, "--set looks: found 1.5, allowed 0 to 64 (whole)");
  expect_refused({"looks=65"}, "--set looks: found 65, allowed 0 to 64 (whole)");
  expect_refused({"looks="}, "--set looks: found \"\"");
  expect_refused({"looks"}, "--set: found \"looks\", allowed KEY=VALUE");
  expect_refused({"looks=1", "looks=1"}, "--set: found looks twice, allowed once");
}

TEST(Fields, UnknownKeysAreAnsweredWithThoseThatResembleThem) {
  expect_refused({"camera.rate.opactiy=1"},
                 "--set: found no key \"camera.rate.opactiy\", allowed camera.rate.opacity");
  expect_refused({"opacity=1"}, "allowed camera.rate.opacity, lidar.rate.opacity (\"--set help\" lists all)");
  expect_refused({"lookz=1"}, "allowed looks (");
  expect_refused({"qqqqqqqq=1"}, "--set: found no key \"qqqqqqqq\", allowed those that \"--set help\" lists");
  Options options;
  expect_error(ErrorKind::kUsage, "settings looks: found 65, ", [&] {
    fields_of(options).apply({"looks=65"}, "settings");
  });
}

TEST(Fields, LinesAreWhatApplyTakes) {
  Options options;
  options.camera.opacity = 0.1 + 0.2;  // more digits than most
  options.order = Order::kRange;
  options.cap = 3;
  const std::vector<std::string> lines = lines_of(options);
  EXPECT_EQ(lines.front(), "camera.rate.opacity=0.30000000000000004");
  Options again;
  fields_of(again).apply(lines);
  EXPECT_EQ(again.camera.opacity, options.camera.opacity);
  EXPECT_EQ(again.order, Order::kRange);
  EXPECT_EQ(lines_of(again), lines);
  EXPECT_NE(lines_of(Options{}), lines);
}

TEST(Fields, CheckNamesTheFieldThatIsOutsideItsRange) {
  EXPECT_NO_THROW(check_fields(Options{}));
  Options options;
  options.lidar.final_share = std::nan("");
  expect_error(ErrorKind::kUsage, "lidar.rate.final_share: found nan, allowed above 0, at most 1", [&] {
    check_fields(options);
  });
  options = {};
  options.order = static_cast<Order>(2);
  expect_error(ErrorKind::kUsage, "order: found 2, allowed range, per_ray", [&] { check_fields(options); });
}

TEST(Fields, HelpHasGroupsWithTheMeaningBelowEachKey) {
  Options options;
  const std::string help = fields_of(options).help();
  EXPECT_EQ(help.find("  camera.rate.opacity=0.3  (0 or more)\n      per step\n"), 0U) << help;
  EXPECT_NE(help.find("\n\nBlending\n  order=per_ray  (range, per_ray)\n"), std::string::npos) << help;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 96U) << line;
  EXPECT_EQ(fields_of(options).find("lidar.rate.opacity")->group, "");
  EXPECT_EQ(fields_of(options).find("looks")->group, "Blending");
}

struct Renamed {
  double weight = 0.5, reach_m = 2.5;
};
template <class F>
constexpr void visit_fields(Renamed& o, F&& field) {
  field("off_trajectory.weight", o.weight, at_least(0.0), "weight");
  field("off_trajectory.reach_m", o.reach_m, range(0.0, 10.0), "m");
}

TEST(Fields, OldKeysSetTheRenamedField) {
  Renamed options;
  fields_of(options).apply({"beside.weight=0.25", "off_trajectory.reach_m=1"});
  EXPECT_EQ(options.weight, 0.25);
  EXPECT_EQ(options.reach_m, 1.0);
  EXPECT_EQ(Fields::current_key("beside.weight"), "off_trajectory.weight");
  EXPECT_EQ(Fields::current_key("off_trajectory.weight"), "off_trajectory.weight");
  expect_error(ErrorKind::kUsage, "off_trajectory.weight twice", [&] {
    fields_of(options).apply({"beside.weight=0.25", "off_trajectory.weight=0.5"});
  });
}

}  // namespace
}  // namespace simuli
