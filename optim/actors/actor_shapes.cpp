#include "optim/actors/actor_shapes.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

#include "host/core/base/split.hpp"

namespace simuli {
namespace {

constexpr double kFirstDecay = 0.9;
constexpr double kSecondDecay = 0.999;
constexpr double kLeastRoot = 1e-15;

constexpr double kRate_m = 0.01;  // initially, per step of Adam: some ten steps for a body's width
constexpr double kShapeFinalShare = 0.1;  // final share of the rate
constexpr double kInterval_s = 0.1;  // between knots in time: a fifth of a leg's swing
/// Share of its distance to the mean of its neighbours, in space and time, by which an offset moves there with
/// each step.
constexpr double kSmooth = 0.01;

/// Separate nodes for two legs and for the gap between them.
constexpr std::array<int, 3> kNodes{3, 4, 6};

/// Parts of the kind names used by datasets.
constexpr std::array<std::string_view, 8> kNonRigid{
    "pedestrian", "person", "people", "cyclist", "bicycl", "rider", "walker", "animal"};
/// Kinds without information: found objects, and "unknown".
constexpr std::array<std::string_view, 4> kUnreported{"", "moving", "unknown", "object"};
/// Largest and smallest size in m of a pedestrian or a rider.
constexpr double kLongest = 2.2, kWidest = 1.2, kLeastHeight = 0.9, kHighest = 2.2;

}  // namespace

bool is_non_rigid(const Actor& actor) {
  const std::string kind = lower(actor.kind);
  if (std::find(kUnreported.begin(), kUnreported.end(), kind) != kUnreported.end()) {
    const double length = std::max(actor.size_m.x(), actor.size_m.y());
    const double width = std::min(actor.size_m.x(), actor.size_m.y());
    return length <= kLongest && width <= kWidest && actor.size_m.z() >= kLeastHeight &&
           actor.size_m.z() <= kHighest;
  }
  return std::any_of(kNonRigid.begin(), kNonRigid.end(), [&](std::string_view part) {
    return kind.find(part) != std::string::npos;
  });
}

void prepare_shapes(std::vector<Actor>& actors) {
  for (Actor& actor : actors) {
    if (!actor.deformation.empty() || actor.track.size() < 2 || !is_non_rigid(actor)) continue;
    Deformation& shape = actor.deformation;
    shape.nodes = kNodes;
    shape.interval_s = kInterval_s;
    shape.start_s = actor.track.front().time_s - Actor::kReach_s;
    const double lasts_s = actor.track.back().time_s + Actor::kReach_s - shape.start_s;
    const double knots = std::ceil(lasts_s / shape.interval_s) + 1.0;
    if (knots > static_cast<double>(kMostDeformationKnots)) {
      shape = {};
      continue;
    }
    shape.offsets_m.assign(3 * shape.node_count() * static_cast<std::size_t>(knots), 0.0);
  }
}

void ActorShapes::step(std::vector<Actor>& actors,
                       const std::vector<DeformationGradient>& gradients,
                       double time_start_s,
                       double time_end_s,
                       double progress) {
  moments_.resize(actors.size());
  const double rate = kRate_m * std::pow(kShapeFinalShare, progress);
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    Deformation& shape = actors[i].deformation;
    const std::size_t row = 3 * shape.node_count();
    std::map<std::size_t, std::vector<double>> by_knot;
    const auto add = [&](double time_s, const std::vector<double>& gradient) {
      if (gradient.size() != row) return;
      const bool finite =
          std::all_of(gradient.begin(), gradient.end(), [](double g) { return std::isfinite(g); });
      const bool any = std::any_of(gradient.begin(), gradient.end(), [](double g) { return g != 0.0; });
      if (!finite || !any) return;
      const Deformation::KnotShares at = shape.shares(time_s);
      for (std::size_t k = 0; k < 4; ++k) {
        std::vector<double>& sum = by_knot.try_emplace(at.knot[k], row, 0.0).first->second;
        for (std::size_t j = 0; j < row; ++j) sum[j] += at.share[k] * gradient[j];
      }
    };
    add(time_start_s, gradients[i].start);
    add(time_end_s, gradients[i].end);
    for (const auto& [knot, gradient] : by_knot) move(shape, moments_[i], knot, gradient, rate);
    for (const auto& [knot, gradient] : by_knot) smooth(shape, knot);
  }
}

void ActorShapes::move(Deformation& shape,
                       Moments& moments,
                       std::size_t knot,
                       const std::vector<double>& gradient,
                       double rate) {
  moments.first.resize(shape.offsets_m.size(), 0.0);
  moments.second.resize(shape.offsets_m.size(), 0.0);
  moments.steps.resize(shape.knots(), 0.0);
  const double steps = ++moments.steps[knot];
  const double bias1 = 1.0 - std::pow(kFirstDecay, steps), bias2 = 1.0 - std::pow(kSecondDecay, steps);
  for (std::size_t j = 0; j < gradient.size(); ++j) {
    const std::size_t at = knot * gradient.size() + j;
    double& first = moments.first[at];
    double& second = moments.second[at];
    first = kFirstDecay * first + (1.0 - kFirstDecay) * gradient[j];
    second = kSecondDecay * second + (1.0 - kSecondDecay) * gradient[j] * gradient[j];
    shape.offsets_m[at] -= rate * (first / bias1) / (std::sqrt(second / bias2) + kLeastRoot);
  }
}

/// Separate from the gradient, like decoupled weight decay: Adam would take full steps for a small smoothing
/// gradient.
void ActorShapes::smooth(Deformation& shape, std::size_t knot) const {
  const auto [length, width, height] = shape.nodes;
  const std::size_t row = 3 * shape.node_count();
  const double* const all = shape.offsets_m.data();
  const std::vector<double> own(all + knot * row, all + (knot + 1) * row);
  for (int z = 0; z < height; ++z) {
    for (int y = 0; y < width; ++y) {
      for (int x = 0; x < length; ++x) {
        const auto node = [&, l = length, w = width](int i, int j, int k) {
          return 3 * static_cast<std::size_t>((k * w + j) * l + i);
        };
        const std::size_t here = node(x, y, z);
        for (std::size_t c = 0; c < 3; ++c) {
          double sum = 0.0, count = 0.0;
          const auto add = [&](bool there, double value) {
            if (!there) return;
            sum += value;
            ++count;
          };
          add(x > 0, x > 0 ? own[node(x - 1, y, z) + c] : 0.0);
          add(x + 1 < length, x + 1 < length ? own[node(x + 1, y, z) + c] : 0.0);
          add(y > 0, y > 0 ? own[node(x, y - 1, z) + c] : 0.0);
          add(y + 1 < width, y + 1 < width ? own[node(x, y + 1, z) + c] : 0.0);
          add(z > 0, z > 0 ? own[node(x, y, z - 1) + c] : 0.0);
          add(z + 1 < height, z + 1 < height ? own[node(x, y, z + 1) + c] : 0.0);
          add(knot > 0, knot > 0 ? all[(knot - 1) * row + here + c] : 0.0);
          const bool later = knot + 1 < shape.knots();
          add(later, later ? all[(knot + 1) * row + here + c] : 0.0);
          double& value = shape.offsets_m[knot * row + here + c];
          value += kSmooth * (sum / count - own[here + c]);
        }
      }
    }
  }
}

std::vector<double> ActorShapes::numbers(const std::vector<Actor>& actors) const {
  std::vector<double> out;
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const Deformation& shape = actors[i].deformation;
    Moments m = i < moments_.size() ? moments_[i] : Moments{};
    m.first.resize(shape.offsets_m.size(), 0.0);
    m.second.resize(shape.offsets_m.size(), 0.0);
    m.steps.resize(shape.knots(), 0.0);
    for (const std::vector<double>* const part : {&m.first, &m.second, &m.steps})
      out.insert(out.end(), part->begin(), part->end());
  }
  return out;
}

void ActorShapes::set_numbers(const std::vector<Actor>& actors, std::span<const double> numbers) {
  moments_.assign(actors.size(), {});
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const Deformation& shape = actors[i].deformation;
    const auto take = [&](std::vector<double>& to, std::size_t count) {
      to.assign(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(count));
      numbers = numbers.subspan(count);
    };
    take(moments_[i].first, shape.offsets_m.size());
    take(moments_[i].second, shape.offsets_m.size());
    take(moments_[i].steps, shape.knots());
  }
}

}  // namespace simuli
