#include "optim/complete/inpaint_disocclusions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/core/scene/edit.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/core/scene/particle_order.hpp"
#include "optim/complete/inpaint_views.hpp"
#include "optim/eval/sweep_pair.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {
namespace {

constexpr float kHidden =
    3.0F;  // ratio of occluded to visible weight from which a particle counts as occluded
constexpr float kLeastSeen = 0.5F;      // rays: less visible weight counts as unseen
constexpr std::size_t kMostViews = 12;  // per sensor, evenly spread over its training frames
constexpr double kReach_m = 0.3;        // margin around an actor's box that still occludes
constexpr int kCell_px = 2;
constexpr double kCoarse = 2.0;   // side of voxels relative to visible parts: inpainting has no fine detail
constexpr double kLargest = 4.0;  // relative to the pictures' resolution; larger gaps are too far away
constexpr float kOpacityLogit = 3.0F;  // 0.95: no loss will raise it
// Distance by which a view must see past a point to contradict it.
constexpr double kThrough = 0.1, kThrough_m = 0.5;

/// Disoccluded and inpainted parts of one set, by actor.
struct Behind {
  std::vector<std::vector<std::size_t>> hidden;  // [actors] rows of the background's particles
  std::vector<GaussianSet> instead;              // [actors]
};

/// A view without actors.
struct Gap {
  std::size_t view = 0;
  std::size_t open = 0;  // rays
  RayRows rows;
};

/// One set of the scene and the views of its sensors.
class SetFiller {
 public:
  SetFiller(
      const Device& device, const Log& log, const InpaintRecipe& recipe, const Scene& scene, SetKind kind)
      : device_(device),
        recipe_(recipe),
        scene_(scene),
        kind_(kind),
        views_(inpaint_views(log, recipe.frames, kind, kMostViews)) {
    for (const InpaintView& view : views_) {
      if (!view.sensor().is_camera()) continue;
      const Shot shot = view.shot.relative_to(scene_.origin);
      pictures_.emplace_back(
          view.sensor().camera(), shot.world_from_sensor_start, shot.world_from_sensor_end);
    }
  }

  [[nodiscard]] Behind run() {
    const GaussianSet none(kind_, own_set().sh_degree, 0);
    Behind out{std::vector<std::vector<std::size_t>>(scene_.actors.size()),
               std::vector<GaussianSet>(scene_.actors.size(), none)};
    find_actors();
    if (before_.empty()) return out;
    find_hidden(background_of(scene_, kind_), out);
    look_behind(out);
    fill(out);
    return out;
  }

 private:
  [[nodiscard]] bool is_camera() const { return kind_ == SetKind::kCamera; }
  [[nodiscard]] const GaussianSet& own_set() const {
    return kind_ == SetKind::kCamera ? scene_.camera : scene_.lidar;
  }

  /// Finds the occluding actors of each view.
  void find_actors() {
    SceneOnDevice on_device(device_, borrowed(scene_), recipe_.render);
    bool any = false;
    for (const InpaintView& view : views_) {
      std::vector<ActorBox> boxes = boxes_in(scene_, view, kReach_m);
      before_.push_back(boxes.empty() ? ActorsBefore() : actors_before(on_device, view));
      any |= before_.back().any();
      boxes_.push_back(std::move(boxes));
    }
    if (!any) before_.clear();
  }

  /// Moves particles that only occluded rays show to the disoccluded set of their actor; particles that other
  /// rays also show are copied to the inpainted set with the appearance from there.
  void find_hidden(const GaussianSet& background, Behind& out) const {
    const SeenWeights seen =
        seen_weights(device_, background, views_, before_, scene_.origin, recipe_.render);
    std::vector<std::vector<Eigen::Index>> partly(scene_.actors.size());
    for (Eigen::Index i = 0; i < background.size(); ++i) {
      const float before = seen.before_actors(i), elsewhere = seen.elsewhere(i);
      if (before < kLeastSeen || before < kHidden * elsewhere) continue;
      const std::uint32_t actor = hider_of(background.mean().row(i).transpose().cast<double>());
      if (actor == 0) continue;
      out.hidden[actor - 1].push_back(static_cast<std::size_t>(i));
      if (elsewhere >= kLeastSeen) partly[actor - 1].push_back(i);
    }
    for (std::size_t a = 0; a < partly.size(); ++a) {
      GaussianSet as_seen = subset(background, partly[a]);
      for (int k = 1; k < sh_coefficients(as_seen.sh_degree); ++k) as_seen.sh(k).setZero();
      for (std::size_t i = 0; i < partly[a].size(); ++i) {
        const Eigen::Index row = partly[a][i];
        as_seen.sh(0).row(static_cast<Eigen::Index>(i)) = seen.look.row(row) / (seen.elsewhere(row) * kSh0);
      }
      append(out.instead[a], as_seen, 0);
    }
  }

  /// Returns the actor that occludes a point in most views; 0 without one.
  [[nodiscard]] std::uint32_t hider_of(const Eigen::Vector3d& p_scene) const {
    std::vector<int> votes(scene_.actors.size() + 1, 0);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const Eigen::Vector3d origin = views_[v].shot.pose_at(0.5).translation;
      const Eigen::Vector3d direction = (p_scene + scene_.origin - origin).normalized();
      for (const ActorBox& box : boxes_[v]) {
        const BoxInterval in = box.inside(origin, direction);
        votes[box.actor] += in.last > std::max(in.first, 0.0) ? 1 : 0;
      }
    }
    const auto most = std::max_element(votes.begin() + 1, votes.end());
    return *most > 0 ? static_cast<std::uint32_t>(most - votes.begin()) : 0;
  }

  /// Renders the views without actors to find gaps.
  void look_behind(const Behind& behind) {
    Scene seen;
    GaussianSet& set = is_camera() ? seen.camera : seen.lidar;
    set = shown_without(behind);
    seen.origin = scene_.origin;
    seen.environment = scene_.environment;
    seen.camera_background = scene_.camera_background;
    seen.lidar_background = scene_.lidar_background;
    SceneOnDevice on_device(device_, std::move(seen), recipe_.render);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (!before_[v].any()) continue;
      Gap gap{v, 0, rows_of(on_device, views_[v], before_[v])};
      for (std::size_t ray = 0; ray < gap.rows.rays(); ++ray) gap.open += gap.rows.is_hole(ray) ? 1 : 0;
      if (gap.open > 0) gaps_.push_back(std::move(gap));
    }
    std::stable_sort(gaps_.begin(), gaps_.end(), [](const Gap& a, const Gap& b) { return a.open > b.open; });
  }

  [[nodiscard]] GaussianSet shown_without(const Behind& behind) const {
    const GaussianSet background = background_of(scene_, kind_);
    std::vector<bool> is_hidden(static_cast<std::size_t>(background.size()), false);
    for (const auto& rows : behind.hidden) {
      for (const std::size_t row : rows) is_hidden[row] = true;
    }
    std::vector<Eigen::Index> kept;
    for (std::size_t i = 0; i < is_hidden.size(); ++i) {
      if (!is_hidden[i]) kept.push_back(static_cast<Eigen::Index>(i));
    }
    GaussianSet set = subset(background, kept);
    for (const GaussianSet& instead : behind.instead) append(set, instead, 0);
    return set;
  }

  struct Points {
    std::vector<Eigen::Vector3d> at;
    std::vector<PointObservation> observations;
  };
  /// Parts of a picture that inpainting from other views covers; none for a LiDAR.
  [[nodiscard]] Coverage covered(std::size_t v, const std::vector<Points>& of_actor) const {
    Coverage out;
    if (!is_camera()) return out;
    const Camera& camera = views_[v].sensor().camera();
    out = {kCell_px, (camera.width + kCell_px - 1) / kCell_px, (camera.height + kCell_px - 1) / kCell_px, {}};
    out.covered.assign(static_cast<std::size_t>(out.columns) * static_cast<std::size_t>(out.rows), 0);
    for (const Points& points : of_actor) {
      for (std::size_t i = 0; i < points.at.size(); ++i) {
        Eigen::Vector2d pixel;
        double range_m = 0.0;
        if (!pictures_[v].project(points.at[i], pixel, range_m)) continue;
        out.cover(
            pixel,
            0.5 * static_cast<double>(points.observations[i].footprint_m) * camera.focal_px() / range_m);
      }
    }
    return out;
  }
  [[nodiscard]] static bool is_covered(const Coverage& by, std::size_t ray, std::size_t columns) {
    if (by.covered.empty()) return false;
    const std::size_t cell =
        ray / columns / kCell_px * static_cast<std::size_t>(by.columns) + ray % columns / kCell_px;
    return by.covered[cell] != 0;
  }

  void fill(Behind& out) const {
    std::vector<Points> of_actor(scene_.actors.size());
    for (const auto& [v, open, rows] : gaps_) {
      const Coverage filled_before = covered(v, of_actor);
      const double ray_rad = is_camera() ? 1.0 / views_[v].sensor().camera().focal_px() : 0.0;
      for (const FilledRay& filled : inpaint_rows(rows)) {
        if (is_covered(filled_before, filled.ray, rows.columns)) continue;
        Eigen::Vector3d origin, direction;
        views_[v].ray(filled.ray, origin, direction);
        if (!(direction.squaredNorm() > 0.0)) continue;
        Points& points = of_actor[rows.actor[filled.ray] - 1];
        points.at.emplace_back(origin + static_cast<double>(filled.range_m) * direction - scene_.origin);
        points.observations.push_back(
            {filled.range_m,
             static_cast<float>(ray_rad) * filled.range_m,
             Eigen::Vector3f(filled.features[0], filled.features[1], filled.features[2])});
      }
    }
    for (std::size_t a = 0; a < of_actor.size(); ++a) {
      append(out.instead[a], set_of(of_actor[a].at, of_actor[a].observations), 0);
    }
  }

  /// Whether more of the pictures that could show a point see past it than not.
  [[nodiscard]] bool is_seen_through(const Eigen::Vector3d& p_scene) const {
    int past = 0, not_past = 0;
    for (const auto& [v, holes, rows] : gaps_) {
      Eigen::Vector2d pixel;
      double range_m = 0.0;
      if (!pictures_[v].project(p_scene, pixel, range_m)) continue;
      const std::size_t ray = std::min(static_cast<std::size_t>(pixel.y()), rows.rows - 1) * rows.columns +
                              std::min(static_cast<std::size_t>(pixel.x()), rows.columns - 1);
      const auto there_m = static_cast<double>(rows.range_m[ray]);
      const bool open = there_m == 0.0 || there_m > (1.0 + kThrough) * range_m + kThrough_m;
      if (open && rows.actor[ray] == 0) ++past;
      if (rows.is_hole(ray) ||
          (there_m > 0.0 && std::abs(there_m - range_m) < kThrough * range_m + kThrough_m))
        ++not_past;
    }
    return past > not_past;
  }

  /// Makes opaque particles at these points, as initialisation does.
  [[nodiscard]] GaussianSet set_of(const std::vector<Eigen::Vector3d>& at,
                                   std::vector<PointObservation> observations) const {
    InitOptions init = recipe_.init;
    init.voxel_m *= kCoarse;
    init.max_scale_m *= kLargest;
    GaussianSet set(kind_, own_set().sh_degree, 0);
    if (at.empty()) return set;
    if (kind_ == SetKind::kLidar) {
      VoxelGrid grid(init.voxel_m);
      for (std::size_t i = 0; i < at.size(); ++i) {
        grid.add(at[i], static_cast<double>(std::clamp(observations[i].colour[0], 0.0F, 1.0F)));
      }
      const PointSet points = grid.averages();
      init.lidar_sh_degree = set.sh_degree;
      CellOptions cells = kLidarCells;
      cells.voxel_m = init.voxel_m;
      set = lidar_set(points, surface_cells(points, cells), init.voxel_m, init);
    } else {
      PointSet points;
      points.position.resize(3, static_cast<Eigen::Index>(at.size()));
      for (std::size_t i = 0; i < at.size(); ++i) {
        points.position.col(static_cast<Eigen::Index>(i)) = at[i].cast<float>();
      }
      points.intensity.assign(at.size(), 0.0F);
      join_by_footprint(points, observations, init.voxel_m, kCameraVoxel_px);
      std::vector<std::uint32_t> kept;
      for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (is_seen_through(points.position.col(i).cast<double>())) continue;
        observations[kept.size()] = observations[i];
        kept.push_back(i);
      }
      points = points.subset(kept);
      observations.resize(kept.size());
      init.camera_sh_degree = set.sh_degree;
      set = camera_set(points, observations, init);
    }
    set.opacity_logit().setConstant(kOpacityLogit);
    return set;
  }

  Device device_;
  InpaintRecipe recipe_;
  const Scene& scene_;
  SetKind kind_;
  std::vector<InpaintView> views_;
  std::vector<ImageView> pictures_;           // [views] of cameras
  std::vector<ActorsBefore> before_;          // [views]; empty without any actor
  std::vector<std::vector<ActorBox>> boxes_;  // [views]
  std::vector<Gap> gaps_;                     // of the views with gaps, largest first
};

/// Renumbers the disoccluded particles and appends the inpainted ones to the set.
void take_over(const Scene& scene,
               const std::vector<std::size_t>& occluders,
               const Behind& behind,
               GaussianSet& set) {
  if (set.actor.empty()) set.actor.assign(static_cast<std::size_t>(set.size()), 0);
  std::vector<std::size_t> background;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] == 0) background.push_back(i);
  }
  for (std::size_t k = 0; k < occluders.size(); ++k) {
    for (const std::size_t row : behind.hidden[occluders[k]])
      set.actor[background[row]] = disoccluded_number(scene, k);
  }
  for (std::size_t k = 0; k < occluders.size(); ++k) {
    const GaussianSet& instead = behind.instead[occluders[k]];
    if (instead.size() > 0) append(set, instead, inpainted_number(scene, k));
  }
}

}  // namespace

void inpaint_behind_actors(const Device& device,
                           const Log& log,
                           const InpaintRecipe& recipe,
                           SceneFile& file) {
  Scene& scene = file.scene;
  if (scene.actors.empty()) return;
  const Log own = with_sensors_of(file, log);
  const Behind camera = SetFiller(device, own, recipe, scene, SetKind::kCamera).run();
  const Behind lidar = SetFiller(device, own, recipe, scene, SetKind::kLidar).run();
  std::vector<std::size_t> occluders;
  for (std::size_t a = 0; a < scene.actors.size(); ++a) {
    const auto has = [&](const Behind& behind) {
      return !behind.hidden[a].empty() || behind.instead[a].size() > 0;
    };
    if (!has(camera) && !has(lidar)) continue;
    occluders.push_back(a);
    scene.occluders.push_back(scene.actors[a]);
    scene.occluders.back().deformation = {};
  }
  if (occluders.empty()) return;
  take_over(scene, occluders, camera, scene.camera);
  take_over(scene, occluders, lidar, scene.lidar);
  scene = in_coherent_order(std::move(scene));
}

}  // namespace simuli
