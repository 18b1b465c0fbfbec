// Tests the tree's neighbours against all distances, and the anchoring loss against differences.
#include "optim/train/paper/anchor_stage.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/core/scene/particle_order.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;
constexpr std::uint32_t kNeighbours = 50;
constexpr double kAnywhere = std::numeric_limits<double>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using Points = std::vector<Eigen::Vector3f>;

GaussianSet set_at(SetKind kind, const Points& points) {
  GaussianSet set(kind, 0, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) set.mean().row(static_cast<Eigen::Index>(i)) = points[i];
  set.rotation().col(0).setOnes();
  return set;
}

Points cloud(std::size_t count, double spread, std::uint64_t seed) {
  test::Random random(seed);
  Points points(count);
  for (Eigen::Vector3f& p : points) {
    p = Eigen::Vector3d(spread * random.normal(), spread * random.normal(), 0.1 * spread * random.normal())
            .cast<float>();
  }
  return points;
}

/// Returns the indices of the K nearest, by distance, then by index, in the kernel's precision and order of
/// sums, so that equal bits are compared.
template <class T>
std::vector<std::uint32_t> brute_force(const Points& queries, const Points& points, double reach) {
  std::vector<std::uint32_t> result;
  for (const Eigen::Vector3f& query : queries) {
    const Eigen::Matrix<T, 3, 1> q = query.cast<T>();
    std::vector<std::pair<T, std::uint32_t>> all;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Matrix<T, 3, 1> p = points[i].cast<T>();
      const T dx = p.x() - q.x(), dy = p.y() - q.y(), dz = p.z() - q.z();
      const T d2 = dx * dx + dy * dy + dz * dz;
      if (d2 < static_cast<T>(reach * reach)) all.emplace_back(d2, static_cast<std::uint32_t>(i));
    }
    std::sort(all.begin(), all.end());
    for (std::size_t k = 0; k < kNeighbours; ++k) result.push_back(k < all.size() ? all[k].second : kNone);
  }
  return result;
}

struct NeighbourCase {
  const char* name;
  Points queries, points;
  double reach_m = kAnywhere;
};

std::vector<NeighbourCase> neighbour_cases() {
  std::vector<NeighbourCase> cases;
  cases.push_back({"even cloud", cloud(200, 20.0, 1), cloud(5000, 20.0, 2)});
  cases.push_back({"within reach", cloud(200, 20.0, 1), cloud(5000, 20.0, 2), 1.5});
  cases.push_back({"fewer than K", cloud(50, 1.0, 3), cloud(7, 1.0, 4)});
  cases.push_back({"exactly K", cloud(50, 1.0, 3), cloud(kNeighbours, 1.0, 4)});
  cases.push_back({"one", cloud(17, 1.0, 3), cloud(1, 1.0, 4)});
  cases.push_back({"no points", cloud(17, 1.0, 3), {}});
  cases.push_back({"no queries", {}, cloud(300, 1.0, 3)});
  for (const std::size_t n : {15U, 16U, 17U, 255U, 256U, 257U, 4096U, 4097U}) {
    cases.push_back({"sizes about those of leaves and nodes", cloud(20, 5.0, 5), cloud(n, 5.0, n)});
  }
  cases.push_back({"all in one place", cloud(20, 1.0, 5), Points(200, Eigen::Vector3f(1.5F, -2.0F, 3.0F))});
  // Clusters of 0.1 mm, a kilometre apart, and outliers beyond: whole clusters fall in one cell of a grid.
  NeighbourCase clusters{"clusters", {}, {}};
  for (int c = 0; c < 5; ++c) {
    const Eigen::Vector3f centre(1000.0F * static_cast<float>(c), 37.0F * static_cast<float>(c * c), 0.0F);
    for (Eigen::Vector3f p : cloud(400, 1e-4, 10U + static_cast<std::uint64_t>(c))) {
      clusters.points.emplace_back(p + centre);
    }
    for (Eigen::Vector3f p : cloud(20, 2e-4, 20U + static_cast<std::uint64_t>(c))) {
      clusters.queries.emplace_back(p + centre);
    }
  }
  clusters.points.emplace_back(1e7F, 0.0F, 0.0F);
  clusters.points.emplace_back(0.0F, -1e12F, 0.0F);
  cases.push_back(clusters);
  NeighbourCase line{"a line", cloud(100, 10.0, 6), {}};
  for (int i = 0; i < 3000; ++i) line.points.emplace_back(0.01F * static_cast<float>(i), 0.0F, 0.0F);
  cases.push_back(line);
  NeighbourCase lattice{"a lattice, full of ties", {}, {}};
  for (int i = 0; i < 1000; ++i) {
    lattice.points.emplace_back(
        static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100));
  }
  lattice.queries = {lattice.points.begin(), lattice.points.begin() + 300};
  lattice.queries.emplace_back(4.5F, 4.5F, 4.5F);
  cases.push_back(lattice);
  NeighbourCase far{"far away", {}, cloud(3000, 10.0, 7)};
  for (const Eigen::Vector3f& p : cloud(50, 1e5, 8)) far.queries.push_back(p);
  far.queries.emplace_back(1e15F, 1e15F, 0.0F);
  cases.push_back(far);
  NeighbourCase broken{"not numbers", cloud(30, 5.0, 9), cloud(500, 5.0, 10)};
  broken.points[3].x() = kNaN;
  broken.points[499].z() = std::numeric_limits<float>::infinity();
  broken.points[77] = {kNaN, kNaN, kNaN};
  broken.queries[5].y() = kNaN;
  cases.push_back(broken);
  cases.push_back({"nothing but not numbers", cloud(5, 1.0, 9), Points(40, Eigen::Vector3f::Constant(kNaN))});
  return cases;
}

class Anchor : public testing::TestWithParam<Precision> {
 protected:
  void SetUp() override {
    if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  }
  Device device_ = test::device();
};

class AnchorSearch : public testing::TestWithParam<std::pair<Precision, std::size_t>> {
 protected:
  void SetUp() override {
    if (GetParam().first == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device_);
  }
  Device device_ = test::device();
};

TEST_P(AnchorSearch, NeighboursAreThoseOfBruteForce) {
  const auto& [precision, work_items] = GetParam();
  AnchorStage anchor(device_, precision, kNeighbours, work_items);
  for (const NeighbourCase& c : neighbour_cases()) {
    const ParticleBuffers queries(device_, set_at(SetKind::kCamera, c.queries), precision);
    const ParticleBuffers points(device_, set_at(SetKind::kLidar, c.points), precision);
    anchor.candidates().reserve(c.queries.size() * kNeighbours);
    anchor.candidates().fill(0xabababab);
    anchor.assign(queries, points, c.reach_m);
    const std::vector<std::uint32_t> expected = precision == Precision::kFloat
                                                    ? brute_force<float>(c.queries, c.points, c.reach_m)
                                                    : brute_force<double>(c.queries, c.points, c.reach_m);
    const std::vector<std::uint32_t> found = anchor.candidates().download();
    ASSERT_EQ(found.size(), expected.size()) << c.name;
    const auto where = std::mismatch(found.begin(), found.end(), expected.begin());
    EXPECT_TRUE(found == expected) << c.name << ", " << c.points.size() << " points: first difference at "
                                   << where.first - found.begin() << ": " << *where.first << ", not "
                                   << *where.second;
    const std::vector<std::uint32_t> nearest = anchor.nearest().download();
    for (std::size_t i = 0; i < nearest.size(); ++i) EXPECT_EQ(nearest[i], expected[i * kNeighbours]);
  }
}

TEST_P(Anchor, FollowsParticlesToOtherPlaces) {
  const GaussianSet queries = set_at(SetKind::kCamera, cloud(200, 5.0, 11));
  const GaussianSet points = set_at(SetKind::kLidar, cloud(900, 5.0, 12));
  const std::vector<Eigen::Index> query_order = coherent_order(queries), point_order = coherent_order(points);
  AnchorStage moved(device_, GetParam(), kNeighbours), anew(device_, GetParam(), kNeighbours);
  // Some have fewer than K neighbours within reach.
  moved.assign({device_, queries, GetParam()}, {device_, points, GetParam()}, 2.0);
  moved.follow_set(query_order);
  moved.follow_targets(point_order);
  anew.assign({device_, subset(queries, query_order), GetParam()},
              {device_, subset(points, point_order), GetParam()},
              2.0);
  EXPECT_EQ(moved.candidates().download(), anew.candidates().download());
  EXPECT_EQ(moved.nearest().download(), anew.nearest().download());
  EXPECT_FALSE(std::is_sorted(point_order.begin(), point_order.end()));
}

/// A third of the particles belong to the background, the others to two actors.
std::vector<std::uint32_t> actors_of(Eigen::Index count) {
  std::vector<std::uint32_t> actor;
  for (Eigen::Index i = 0; i < count; ++i) actor.push_back(static_cast<std::uint32_t>(i * 7 % 3));
  return actor;
}

TEST_P(Anchor, NeighboursAreOfTheSameActor) {
  const Points queries = cloud(200, 4.0, 1), points = cloud(3000, 4.0, 2);
  AnchorStage anchor(device_, GetParam(), kNeighbours);
  // Actors in both sets, in one set, in none.
  for (const int which : {3, 2, 1, 0}) {
    GaussianSet set = set_at(SetKind::kCamera, queries), targets = set_at(SetKind::kLidar, points);
    if (which & 1) set.actor = actors_of(set.size());
    if (which & 2) targets.actor = actors_of(targets.size());
    anchor.assign({device_, set, GetParam()}, {device_, targets, GetParam()}, 1.0);
    const std::vector<std::uint32_t> found = anchor.candidates().download();
    const auto actor_of = [](const GaussianSet& s, std::size_t i) {
      return s.actor.empty() ? 0 : s.actor[i];
    };
    for (std::uint32_t actor = 0; actor < 3; ++actor) {
      // Brute force over the points of this actor.
      Points own;
      std::vector<std::uint32_t> number;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (actor_of(targets, i) != actor) continue;
        own.push_back(points[i]);
        number.push_back(static_cast<std::uint32_t>(i));
      }
      const std::vector<std::uint32_t> expected = GetParam() == Precision::kFloat
                                                      ? brute_force<float>(queries, own, 1.0)
                                                      : brute_force<double>(queries, own, 1.0);
      std::size_t some = 0;
      for (std::size_t i = 0; i < queries.size(); ++i) {
        if (actor_of(set, i) != actor) continue;
        for (std::size_t k = i * kNeighbours; k < (i + 1) * kNeighbours; ++k) {
          const std::uint32_t id = expected[k] == kNone ? kNone : number[expected[k]];
          ASSERT_EQ(found[k], id) << which << ": query " << i << " of actor " << actor;
          some += id == kNone ? 0U : 1U;
        }
      }
      EXPECT_EQ(some > 100U, actor == 0 || which == 3) << which << ", actor " << actor;
    }
  }
}

TEST_P(Anchor, ACandidateThatChangedItsActorPullsNobody) {
  GaussianSet set = set_at(SetKind::kCamera, {{0.0F, 0.0F, 0.0F}, {5.0F, 0.0F, 0.0F}});
  GaussianSet targets = set_at(SetKind::kLidar, {{0.5F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {5.5F, 0.0F, 0.0F}});
  set.actor = {1, 0};
  targets.actor = {1, 1, 0};
  const ParticleBuffers particles(device_, set, GetParam());
  ParticleBuffers others(device_, targets, GetParam());
  AnchorStage anchor(device_, GetParam(), kNeighbours);
  anchor.assign(particles, others, kAnywhere);
  // Relocates the nearest of the first, and all points of the second, to the background.
  targets.actor = {0, 1, 2};
  others.upload(targets);
  const Buffer<std::uint32_t> keys(device_, "keys", std::vector<std::uint32_t>(2, 1U));
  for (const bool choose : {false, true}) {
    RealBuffer grads(device_, "gradients", GetParam(), particles.params.count());
    grads.fill(0.0);
    anchor.add_gradient(particles, others, keys, 1.0, choose, grads);
    const std::vector<double> found = grads.download_double();
    EXPECT_EQ(found[0], choose ? -1.0 : 0.0);
    EXPECT_EQ(found[1], 0.0);
    EXPECT_EQ(anchor.loss().particles, choose ? 1.0 : 0.0);
    EXPECT_EQ(anchor.loss().distance_m, choose ? 1.0 : 0.0);
  }
}

/// Camera particles anchored to LiDAR particles that have moved since.
struct MovedScene {
  GaussianSet set, targets;
  std::vector<std::uint32_t> keys;  // every seventh is culled
};

MovedScene moved_scene() {
  MovedScene scene{
      set_at(SetKind::kCamera, cloud(120, 3.0, 1)), set_at(SetKind::kLidar, cloud(900, 3.0, 2)), {}};
  for (Eigen::Index i = 0; i < scene.set.size(); ++i) scene.keys.push_back(i % 7 == 0 ? kNone : 5U);
  return scene;
}

void move_targets(GaussianSet& targets) {
  test::Random random(3);
  for (Eigen::Index i = 0; i < targets.size(); ++i) {
    for (int k = 0; k < 3; ++k) targets.mean()(i, k) += static_cast<float>(0.3 * random.normal());
  }
}

TEST_P(Anchor, GradientMatchesDifferencesOfTheDistanceToTheNearestCandidate) {
  MovedScene scene = moved_scene();
  const ParticleBuffers set(device_, scene.set, GetParam());
  ParticleBuffers targets(device_, scene.targets, GetParam());
  AnchorStage anchor(device_, GetParam(), kNeighbours);
  anchor.assign(set, targets, 0.5);
  EXPECT_TRUE(anchor.is_assigned_for(set));
  const std::vector<std::uint32_t> candidates = anchor.candidates().download();
  const std::vector<std::uint32_t> first_nearest = anchor.nearest().download();
  move_targets(scene.targets);
  targets.upload(scene.targets);

  const Buffer<std::uint32_t> keys(device_, "keys", scene.keys);
  RealBuffer grads(device_, "gradients", GetParam(), set.params.count());
  grads.fill(0.25);
  constexpr double kWeight = 0.125;
  anchor.add_gradient(set, targets, keys, kWeight, true, grads);
  const std::vector<double> found = grads.download_double();
  const AnchorLoss loss = anchor.loss();

  const auto nearest_of = [&](std::size_t i, const Eigen::Vector3d& p) {
    std::pair<double, std::uint32_t> best{kAnywhere, kNone};
    for (std::size_t k = 0; k < kNeighbours && candidates[i * kNeighbours + k] != kNone; ++k) {
      const std::uint32_t id = candidates[i * kNeighbours + k];
      best = std::min(best, {(p - scene.targets.mean().row(id).transpose().cast<double>()).norm(), id});
    }
    return best;
  };
  const double tolerance =
      GetParam() == Precision::kDouble ? 1e-8 : 1e-6;  // rounding of the quotient; of float
  const std::vector<std::uint32_t> nearest = anchor.nearest().download();
  double sum = 0.0, anchored = 0.0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < scene.keys.size(); ++i) {
    const Eigen::Vector3d p = scene.set.mean().row(static_cast<Eigen::Index>(i)).transpose().cast<double>();
    const bool visible = scene.keys[i] != kNone;
    const auto [distance, id] = nearest_of(i, p);
    if (visible && id != kNone) {
      sum += distance;
      anchored += 1.0;
      changed += nearest[i] != first_nearest[i] ? 1U : 0U;
    }
    EXPECT_EQ(nearest[i], visible ? id : first_nearest[i]);
    for (int row = 0; row < param_rows(0); ++row) {
      double expected = 0.25;
      if (row < 3 && visible && id != kNone) {
        constexpr double kStep = 1e-5;
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(row);
        expected += kWeight * (nearest_of(i, p + step).first - nearest_of(i, p - step).first) / (2.0 * kStep);
      }
      EXPECT_NEAR(found[static_cast<std::size_t>(row) * set.stride + i], expected, tolerance);
    }
  }
  EXPECT_GT(changed, 10U);  // the nearest at assignment is not sufficient
  EXPECT_EQ(loss.particles, anchored);
  EXPECT_NEAR(loss.distance_m, sum, 1e-6 * sum);
  EXPECT_GT(anchored, 50.0);
  EXPECT_LT(anchored, static_cast<double>(scene.keys.size()) - 20.0);  // culled, or out of reach

  // Without a new choice the assigned neighbour remains, wherever it moves.
  move_targets(scene.targets);
  targets.upload(scene.targets);
  anchor.add_gradient(set, targets, keys, kWeight, false, grads);
  EXPECT_EQ(anchor.nearest().download(), nearest);
}

TEST_P(Anchor, AParticleOnItsAnchorHasNoGradient) {
  const Points points = cloud(40, 1.0, 4);
  const ParticleBuffers set(device_, set_at(SetKind::kCamera, points), GetParam());
  const ParticleBuffers targets(device_, set_at(SetKind::kLidar, points), GetParam());
  AnchorStage anchor(device_, GetParam(), kNeighbours);
  anchor.assign(set, targets, kAnywhere);
  const Buffer<std::uint32_t> keys(device_, "keys", std::vector<std::uint32_t>(points.size(), 1U));
  RealBuffer grads(device_, "gradients", GetParam(), set.params.count());
  grads.fill(0.0);
  anchor.add_gradient(set, targets, keys, 1.0, true, grads);
  for (const double g : grads.download_double()) EXPECT_EQ(g, 0.0);
  EXPECT_EQ(anchor.loss().mean_m(), 0.0);
  EXPECT_EQ(anchor.loss().particles, 40.0);
}

INSTANTIATE_TEST_SUITE_P(All,
                         AnchorSearch,
                         testing::Values(std::pair{Precision::kFloat, std::size_t{1}},
                                         std::pair{Precision::kDouble, std::size_t{1}},
                                         std::pair{Precision::kFloat, std::size_t{16}},
                                         std::pair{Precision::kDouble, std::size_t{16}}),
                         [](const auto& pair) {
                           return std::string(pair.param.second == 1 ? "cpu" : "gpu") +
                                  (pair.param.first == Precision::kFloat ? "_in_float" : "_in_double");
                         });
INSTANTIATE_TEST_SUITE_P(All,
                         Anchor,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli
