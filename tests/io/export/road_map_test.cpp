#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <vector>

#include "io/export/drive_parts.hpp"
#include "io/export/road_line.hpp"

namespace simuli {
namespace {

/// Returns the attributes of each element of this name, in order.
std::vector<std::map<std::string, double>> elements(const std::string& xml, const std::string& name) {
  std::vector<std::map<std::string, double>> out;
  for (std::size_t at = xml.find('<' + name + ' '); at != std::string::npos;
       at = xml.find('<' + name + ' ', at + 1)) {
    const std::string tag = xml.substr(at, xml.find('>', at) - at);
    std::map<std::string, double>& values = out.emplace_back();
    for (std::size_t is = tag.find("=\""); is != std::string::npos; is = tag.find("=\"", is + 1)) {
      const std::size_t space = tag.rfind(' ', is);
      values[tag.substr(space + 1, is - space - 1)] = std::strtod(tag.c_str() + is + 2, nullptr);
    }
    const std::string inside = xml.substr(at + tag.size(), 40);
    if (inside.find("><arc") == 0) values["curvature"] = std::strtod(inside.c_str() + 17, nullptr);
  }
  return out;
}

struct RoadPoint {
  double s;
  Eigen::Vector2d place;
  double heading;
};

/// Follows the reference line in steps of a centimetre, independently of the exporter. Pieces must start
/// where the previous ones end and, if `smooth`, with the same heading.
std::vector<RoadPoint> walked(const std::string& xml, bool smooth = true) {
  std::vector<RoadPoint> out;
  double s = 0.0;
  for (const auto& piece : elements(xml, "geometry")) {
    RoadPoint point{s, {piece.at("x"), piece.at("y")}, piece.at("hdg")};
    EXPECT_NEAR(piece.at("s"), s, 1e-6);
    EXPECT_GT(piece.at("length"), 0.0);
    if (!out.empty()) {
      EXPECT_LT((point.place - out.back().place).norm(), 1e-4) << s;
      const double turn = std::remainder(point.heading - out.back().heading, 2.0 * M_PI);
      EXPECT_LT(std::abs(turn), smooth ? 1e-3 : M_PI) << s;
    }
    out.push_back(point);
    const double curvature = piece.count("curvature") ? piece.at("curvature") : 0.0;
    const int steps = static_cast<int>(std::ceil(piece.at("length") / 0.01));
    const double step = piece.at("length") / steps;
    for (int i = 0; i < steps; ++i) {
      const double middle = point.heading + 0.5 * step * curvature;
      point.place += step * Eigen::Vector2d(std::cos(middle), std::sin(middle));
      point.heading += step * curvature;
      point.s += step;
      out.push_back(point);
    }
    s += piece.at("length");
  }
  EXPECT_NEAR(elements(xml, "road").at(0).at("length"), s, 1e-6);
  return out;
}

double distance_to(const std::vector<RoadPoint>& road, const Eigen::Vector2d& place) {
  double best = HUGE_VAL;
  for (const RoadPoint& point : road) best = std::min(best, (point.place - place).norm());
  return best;
}

double elevation_at(const std::string& xml, double s) {
  double out = NAN;
  for (const auto& e : elements(xml, "elevation")) {
    const double ds = s - e.at("s");
    if (ds >= -1e-9) out = e.at("a") + ds * (e.at("b") + ds * (e.at("c") + ds * e.at("d")));
  }
  return out;
}

Pose at(double x, double y, double z, double heading) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ())), {x, y, z}};
}

/// Returns poses along a line with varying curvature at each of `along_m`; 1.8 m above the ground.
std::vector<Pose> bends(const std::vector<double>& along_m) {
  std::vector<Pose> out;
  for (const double along : along_m) {
    Eigen::Vector2d place(0.0, 0.0);
    double heading = 0.0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      const double s = along * (i + 0.5) / kSteps;
      heading = 0.9 * std::sin(s / 25.0) + s / 150.0;  // radius down to 23 m
      place += along / kSteps * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    }
    out.push_back(at(place.x(), place.y(), 1.8, heading));
  }
  return out;
}

TEST(RoadMap, LiesAlongAPathThatStandsAndReverses) {
  std::vector<double> along;
  for (double s = 0.0; s < 120.0; s += 0.8) along.push_back(s);
  for (int i = 0; i < 100; ++i) along.push_back(120.0 + 0.02 * std::sin(1.7 * i));  // at rest
  for (double s = 120.0; s > 112.0; s -= 0.3) along.push_back(s);                   // reverses
  for (double s = 112.0; s < 220.0; s += 1.1) along.push_back(s);
  const std::vector<Pose> rig = bends(along);
  const std::string xml = road_map(rig, GroundMap());
  const std::vector<RoadPoint> road = walked(xml);
  double farthest = 0.0;
  for (const Pose& pose : rig) farthest = std::max(farthest, distance_to(road, pose.translation.head<2>()));
  EXPECT_LT(farthest, 0.05);
  EXPECT_NEAR(road.back().s, 219.8, 1.2);
  EXPECT_LT(elements(xml, "geometry").size(), 60U);
  EXPECT_NEAR(elevation_at(xml, 100.0), 1.8, 1e-6);  // height of the rig: the ground is unknown
  EXPECT_EQ(xml.find("geoReference"), std::string::npos);
}

TEST(RoadMap, NoisyPlacesGiveASmoothLine) {
  std::vector<Pose> rig = bends([] {
    std::vector<double> along;
    for (double s = 0.0; s < 200.0; s += 0.5) along.push_back(s);
    return along;
  }());
  for (std::size_t i = 0; i < rig.size(); ++i)
    rig[i].translation.y() += 0.015 * std::sin(2.3 * static_cast<double>(i));
  const std::vector<RoadPoint> road = walked(road_map(rig, GroundMap()));
  for (const Pose& pose : rig) EXPECT_LT(distance_to(road, pose.translation.head<2>()), 0.05);
}

TEST(RoadMap, FewPiecesAreEnoughForALineAndACircle) {
  std::vector<Pose> line, circle;
  for (int i = 0; i < 90; ++i) {
    line.push_back(at(3.0 + i, 2.0 - 2.0 * i, 0.0, 0.0));
    circle.push_back(at(40.0 * std::sin(0.02 * i), 40.0 - 40.0 * std::cos(0.02 * i), 0.0, 0.02 * i));
  }
  const RoadLine straight = road_line(line);
  EXPECT_LE(straight.pieces.size(), 8U);
  EXPECT_NEAR(straight.length_m(), 89.0 * std::sqrt(5.0), RoadLine::kGrid_m);
  for (const RoadPiece& piece : straight.pieces) EXPECT_EQ(piece.curvature_per_m, 0.0);
  const RoadLine round = road_line(circle);
  EXPECT_LE(round.pieces.size(), 4U);
  EXPECT_NEAR(round.length_m(), 40.0 * 0.02 * 89, RoadLine::kGrid_m);
  for (const RoadPiece& piece : round.pieces) EXPECT_NEAR(piece.curvature_per_m, 1.0 / 40.0, 1e-9);
  EXPECT_NEAR(round.places.back().s_m, round.length_m(), 1e-6);
}

TEST(RoadMap, EndsWhereTheDriveEnds) {
  std::vector<Pose> rig;
  for (int i = 0; i <= 301; ++i) rig.push_back(at(0.1 * i, 0.0, 0.0, 0.0));
  const double length = road_line(rig).length_m();
  EXPECT_NEAR(length, 30.1, RoadLine::kGrid_m);
  EXPECT_LE(length, 30.1);
  // position at which CARLA looks up the end
  EXPECT_LT(static_cast<double>(static_cast<float>(length)), length);
  EXPECT_GT(static_cast<double>(static_cast<float>(length)), length - 1e-6);
}

TEST(RoadMap, StandingRigsGetAShortRoad) {
  const double heading = 0.5;
  for (const std::vector<Pose>& rig :
       {std::vector<Pose>{at(7.0, 8.0, 1.0, heading)},
        std::vector<Pose>{
            at(7.0, 8.0, 1.0, heading), at(7.02, 8.0, 1.0, heading), at(7.0, 8.01, 1.0, heading)}}) {
    const std::vector<RoadPoint> road = walked(road_map(rig, GroundMap()));
    EXPECT_NEAR(road.back().s, RoadLine::kShortest_m, RoadLine::kGrid_m);
    EXPECT_LT(distance_to(road, {7.0, 8.0}), 0.01);
    EXPECT_NEAR(road.front().heading, heading, 1e-9);
  }
}

TEST(RoadMap, FollowsWhatWasDrivenWhicheverWayTheRigFaced) {
  std::vector<Pose> back, turned;
  for (int i = 0; i < 40; ++i) back.push_back(at(-0.5 * i, 0.0, 0.0, 0.0));
  const std::vector<RoadPoint> road = walked(road_map(back, GroundMap()));
  EXPECT_NEAR(road.front().place.x(), 0.0, 1e-6);
  EXPECT_NEAR(road.back().place.x(), -19.5, 0.3);
  // Out of a gap, backwards, and away: the road is the longer direction.
  for (int i = 0; i < 10; ++i) turned.push_back(at(0.0, -0.5 * i, 0.0, M_PI / 2.0));
  for (int i = 0; i < 60; ++i) turned.push_back(at(0.0, -4.5 + 0.5 * i, 0.0, M_PI / 2.0));
  const std::vector<RoadPoint> off = walked(road_map(turned, GroundMap()));
  EXPECT_LT(distance_to(off, {0.0, 25.0}), 0.3);
  EXPECT_NEAR(off.front().place.y(), 0.0, 1e-6);
  EXPECT_NEAR(off.back().s, 25.0, 0.6);
}

TEST(RoadMap, TurnsInThreeMovesStayInOnePiece) {
  std::vector<Pose> rig;
  for (int i = 0; i <= 40; ++i) rig.push_back(at(0.5 * i, 0.0, 0.0, 0.0));
  for (int i = 1; i <= 12; ++i) {  // backwards to the right
    const double turn = 0.1 * i;
    rig.push_back(at(20.0 - 5.0 * std::sin(turn), 5.0 * std::cos(turn) - 5.0, 0.0, turn));
  }
  const Pose there = rig.back();
  for (int i = 1; i <= 60; ++i) rig.push_back(there * at(0.5 * i, 0.0, 0.0, 0.0));
  const std::string xml = road_map(rig, GroundMap());
  const std::vector<RoadPoint> road = walked(xml, false);
  EXPECT_NEAR(road.front().place.x(), 0.0, 1e-6);
  EXPECT_LT((road.back().place - rig.back().translation.head<2>()).norm(), 0.6);
  EXPECT_LT(road.back().s, 80.0);
  for (const RoadPoint& point : road) ASSERT_TRUE(point.place.allFinite());
}

TEST(RoadMap, LiesOnTheGroundAsFarAsThatIsKnown) {
  std::vector<Pose> rig;
  for (int i = 0; i <= 120; ++i) rig.push_back(at(0.5 * i, 0.0, 0.02 * 0.5 * i + 1.5, 0.0));
  Eigen::Matrix3Xf slope(3, 8000);
  for (int i = 0; i < 8000; ++i) {
    const float x = 0.1F * static_cast<float>(i / 20) - 2.0F;  // up to x = 38 m
    slope.col(i) << x, 0.3F * static_cast<float>(i % 20) - 3.0F, 0.02F * x;
  }
  GroundMap ground;
  ground.add(slope);
  ground.finish();
  const std::string xml = road_map(rig, ground);
  for (const double s : {0.0, 1.0, 12.3, 30.0, 45.0, 59.5})
    EXPECT_NEAR(elevation_at(xml, s), 0.02 * s, 0.03) << s;
  const auto pieces = elements(xml, "elevation");
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    EXPECT_NEAR(elevation_at(xml, pieces[i].at("s") - 1e-6), pieces[i].at("a"), 1e-4);
  }
}

TEST(RoadMap, HasALaneAboutThePathAndOneBeside) {
  const std::string xml = road_map({at(0.0, 0.0, 0.0, 0.0), at(30.0, 0.0, 0.0, 0.0)}, GroundMap());
  EXPECT_EQ(elements(xml, "laneOffset").at(0).at("a"), 0.5 * kLaneWidth_m);
  const auto lanes = elements(xml, "lane");
  ASSERT_EQ(lanes.size(), 3U);
  EXPECT_EQ(lanes[0].at("id"), 1.0);
  EXPECT_EQ(lanes[2].at("id"), -1.0);
  for (const auto& width : elements(xml, "width")) EXPECT_EQ(width.at("a"), kLaneWidth_m);
  EXPECT_NE(xml.find("not from a survey"), std::string::npos);
  const auto header = elements(xml, "header").at(0);
  EXPECT_EQ(header.at("revMinor"), 4.0);
  EXPECT_NEAR(header.at("east"), 30.0, 0.002);
}

}  // namespace
}  // namespace simuli
