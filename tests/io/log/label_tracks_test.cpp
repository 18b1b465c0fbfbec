// Tests actors from labelled boxes: size, order, repeated labels, names.
#include "io/log/label_tracks.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;
using test::expect_input_error;

KeyPose key(double time_s, double x_m) {
  return {time_s, Pose{Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}}};
}

TEST(LabelTracks, SizeIsTheMedianOfEachSide) {
  LabelTracks tracks;
  tracks.add("a", "car", key(0.0, 0.0), {4.0, 1.9, 1.5});
  tracks.add("a", "car", key(0.1, 1.0), {4.4, 1.8, 1.7});
  tracks.add("a", "car", key(0.2, 2.0), {4.1, 1.7, 1.6});
  LabelReport report;
  const std::vector<Actor> actors = tracks.take("labels", report);
  ASSERT_EQ(actors.size(), 1U);
  EXPECT_EQ(actors[0].size_m, Vector3d(4.1, 1.8, 1.6));
}

TEST(LabelTracks, PosesAreInTimeOrderAndRepeatedOnesAreCounted) {
  LabelTracks tracks;
  tracks.add("a", "car", key(0.2, 2.0), {4.0, 2.0, 1.5});
  tracks.add("b", "car", key(0.2, 9.0), {4.0, 2.0, 1.5});
  tracks.add("a", "car", key(0.0, 0.0), {4.0, 2.0, 1.5});
  tracks.add("a", "car", key(0.2, 5.0), {4.0, 2.0, 1.5});
  LabelReport report;
  const std::vector<Actor> actors = tracks.take("labels", report);
  ASSERT_EQ(actors.size(), 2U);
  ASSERT_EQ(actors[0].track.size(), 2U);
  EXPECT_EQ(actors[0].track[0].time_s, 0.0);
  EXPECT_EQ(actors[0].track[1].world_from_actor.translation.x(), 2.0);  // the first of the two labels
  EXPECT_EQ(actors[1].track.size(), 1U);
  EXPECT_EQ(report.kept, 3U);
  EXPECT_EQ(report.repeated, 1U);
}

TEST(LabelTracks, NamesAreUnique) {
  LabelTracks tracks;
  const Vector3d size_m(4.0, 2.0, 1.5);
  tracks.add("x", "vehicle.car", key(0.0, 0.0), size_m);
  tracks.add("y", "Tram / Subway", key(0.0, 0.0), size_m);
  tracks.add("z", "car", key(0.0, 0.0), size_m, "own");
  tracks.add("w", "car", key(0.0, 0.0), size_m, "own");
  tracks.add("x", "bus", key(0.1, 0.0), size_m);
  LabelReport report;
  const std::vector<Actor> actors = tracks.take("labels", report);
  ASSERT_EQ(actors.size(), 4U);
  EXPECT_EQ(actors[0].name, "car_0");
  EXPECT_EQ(actors[0].kind, "vehicle.car");
  EXPECT_EQ(actors[1].name, "tram___subway_1");
  EXPECT_EQ(actors[2].name, "own");
  EXPECT_EQ(actors[3].name, "own_2");
}

TEST(LabelTracks, ActorsAreValidated) {
  LabelTracks tracks;
  tracks.add("a", "car", key(0.0, std::numeric_limits<double>::quiet_NaN()), {4.0, 2.0, 1.5});
  LabelReport report;
  expect_input_error([&] { (void)tracks.take("labels.json", report); }, {"labels.json", "car_0: track[0]"});
}

}  // namespace
}  // namespace simuli
