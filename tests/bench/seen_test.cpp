// A board before a wall below the sky, seen by a camera that taught and by others.
#include "bench/paper/seen.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "io/synth/street.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kWall_m = 20.0, kWallTop_m = 6.0;    // x, z
constexpr double kBoard_m = 10.0, kBoardTop_m = 3.0;  // x, z
constexpr double kBoardHalf_m = 1.0;                  // of its width

class BoardBeforeWall : public TracedWorld {
 public:
  /// The board is the street's car, or stands still.
  explicit BoardBeforeWall(std::optional<StreetCar> car = std::nullopt) : car_(car) {}
  [[nodiscard]] double board_x(double time_s) const { return car_ ? car_->position(time_s).x() : kBoard_m; }
  [[nodiscard]] StreetHit trace(const Vector3d& origin,
                                const Vector3d& direction,
                                double time_s,
                                double max_range) const override {
    StreetHit out;
    const auto meet = [&](double x, double half_m, double top_m, bool on_car) {
      const double range = (x - origin.x()) / direction.x();
      const Vector3d p = origin + range * direction;
      if (out.hit || !(range > 0.0) || range > max_range || std::abs(p.y()) > half_m) return;
      if (p.z() > top_m) return;
      out.hit = true, out.range = range, out.on_car = on_car;
      out.normal = Vector3d(direction.x() > 0.0 ? -1.0 : 1.0, 0.0, 0.0);
    };
    meet(board_x(time_s), kBoardHalf_m, kBoardTop_m, car_.has_value());
    meet(kWall_m, 1e3, kWallTop_m, false);
    return out;
  }

 private:
  std::optional<StreetCar> car_;
};

struct Views {
  LogCamera camera = street_log({.output = "none", .image_width = 64, .image_height = 36}).cameras.front();

  [[nodiscard]] static Trajectory still(const Vector3d& at) {
    const Pose pose{Eigen::Quaterniond::Identity(), at};
    return Trajectory({{-1.0, pose}, {2.0, pose}});
  }
  [[nodiscard]] std::vector<Seen> seen(const TracedWorld& world,
                                       const Vector3d& from,
                                       double time_s = 0.0,
                                       const std::optional<StreetCar>& car = std::nullopt) const {
    Log log;
    log.cameras = {camera};
    log.images = {{"front", "", 0.0, 0.0}};
    log.world_from_rig = still(Vector3d::Zero());
    return SeenBefore(world, car, log).of(camera, still(from), time_s, time_s);
  }
  /// Where the ray of a pixel of a camera moved by `from` leaves.
  [[nodiscard]] Vector3d origin(const Vector3d& from) const {
    return from + camera.rig_from_camera.translation;
  }
  [[nodiscard]] Vector3d direction(std::size_t i) const {
    const Eigen::Vector2d pixel(static_cast<double>(i % 64) + 0.5, static_cast<double>(i / 64) + 0.5);
    return (camera.rig_from_camera.rotation * camera.model.unproject(pixel)).normalized();
  }
};

TEST(Seen, IsAllFromWhereThePictureWasTaken) {
  const Views views;
  for (const Seen seen : views.seen(BoardBeforeWall(), Vector3d::Zero())) EXPECT_EQ(seen, Seen::kWell);
}

TEST(Seen, IsNotWhatTheBoardHidNorWhatLiesBesideThePicture) {
  const Views views;
  const BoardBeforeWall world;
  const Vector3d left(0.0, 3.0, 0.0);
  const std::vector<Seen> seen = views.seen(world, left);
  std::size_t hidden = 0, beside = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Vector3d direction = views.direction(i);
    const StreetHit hit = world.trace(views.origin(left), direction, 0.0, 1e3);
    bool expected = true;
    if (hit.hit) {
      const Vector3d way = views.origin(left) + hit.range * direction - views.origin(Vector3d::Zero());
      const Vector3d on_board = views.origin(Vector3d::Zero()) + kBoard_m / way.x() * way -
                                views.camera.rig_from_camera.translation.x() / way.x() * way;
      const bool is_hidden = hit.range * direction.x() > kBoard_m && std::abs(on_board.y()) < kBoardHalf_m &&
                             on_board.z() < kBoardTop_m;
      const bool is_beside = std::abs(way.y()) > way.x() * std::tan(40.0 * std::numbers::pi / 180.0);
      hidden += is_hidden, beside += is_beside;
      expected = !is_hidden && !is_beside;
    }
    EXPECT_EQ(seen[i] != Seen::kNever, expected) << i % 64 << ' ' << i / 64;
  }
  EXPECT_GT(hidden, 20U);
  EXPECT_GT(beside, 20U);
}

TEST(Seen, IsCoarseWhereAPictureHasFewerPixelsOfIt) {
  const Views views;
  const BoardBeforeWall world;
  // The wall above the board.
  const auto middle = [&](double forward_m) {
    return views.seen(world, {forward_m, 0.0, 3.5})[18 * 64 + 32];
  };
  const double away_m = kWall_m - views.origin(Vector3d::Zero()).x();
  ASSERT_GT(kWall_m - 0.52 * away_m, kBoard_m);  // behind it
  EXPECT_EQ(middle(away_m * 0.48), Seen::kWell);
  EXPECT_EQ(middle(away_m * 0.55), Seen::kCoarsely);
}

TEST(Seen, IsWhatDrivesWhereverItIsThen) {
  const Views views;
  const StreetCar car{.start_m = kBoard_m, .lane_m = 0.0, .speed_m_per_s = 4.0};
  const BoardBeforeWall world(car);
  const std::vector<Seen> seen = views.seen(world, Vector3d::Zero(), 1.0, car);
  const std::vector<Seen> as_if_still = views.seen(world, Vector3d::Zero(), 1.0);
  std::size_t board = 0, revealed = 0;
  for (std::size_t i = 0; i < std::size_t{26} * 64; ++i) {  // below, it was lower than the picture
    const StreetHit now = world.trace(views.origin(Vector3d::Zero()), views.direction(i), 1.0, 1e3);
    const StreetHit then = world.trace(views.origin(Vector3d::Zero()), views.direction(i), 0.0, 1e3);
    board += now.on_car, revealed += then.on_car && !now.on_car;
    EXPECT_EQ(seen[i] == Seen::kNever, then.on_car && !now.on_car) << i % 64 << ' ' << i / 64;
    EXPECT_EQ(as_if_still[i] == Seen::kNever, then.on_car) << i % 64 << ' ' << i / 64;
  }
  EXPECT_GT(board, 20U);
  EXPECT_GT(revealed, 20U);
}

TEST(SeenErrors, AreThoseOfEachKind) {
  Image truth(2, 2, 3), rendered(2, 2, 3);
  for (int c = 0; c < 3; ++c) {
    rendered.at(0, 0, c) = 0.5F;   // never seen
    rendered.at(1, 0, c) = 0.1F;   // well
    rendered.at(0, 1, c) = 0.01F;  // coarsely
  }
  const std::vector<Seen> seen{Seen::kNever, Seen::kWell, Seen::kCoarsely, Seen::kWell};
  SeenErrors errors, path;
  errors.add(rendered, truth, seen);
  EXPECT_DOUBLE_EQ(errors.share(Seen::kNever), 0.25);
  EXPECT_DOUBLE_EQ(errors.share(Seen::kWell), 0.5);
  EXPECT_NEAR(errors.psnr_db(Seen::kNever), -10.0 * std::log10(0.25), 1e-5);
  EXPECT_NEAR(errors.psnr_db(Seen::kWell), -10.0 * std::log10(0.005), 1e-5);
  EXPECT_NEAR(errors.psnr_db(Seen::kCoarsely), 40.0, 1e-4);
  // A path that is off by 0.1 wherever it was seen.
  path.add(Image(1, 1, 3),
           [] {
             Image off(1, 1, 3);
             off.data = {0.1F, 0.1F, 0.1F};
             return off;
           }(),
           {Seen::kWell});
  EXPECT_NEAR(errors.psnr_of_seen_as_in_db(path), -10.0 * std::log10(0.25 * (0.25 + 3.0 * 0.01)), 1e-5);
}

}  // namespace
}  // namespace simuli::bench
