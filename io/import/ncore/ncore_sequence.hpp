#pragma once
// The stores of one NCore sequence and what they hold. For io/import/ncore/*.cpp and tests.
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"
#include "io/ncore/clock.hpp"
#include "io/ncore/poses.hpp"
#include "io/ncore/rays.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli::ncore {

/// A group of a store.
struct ZarrGroup {
  const ZarrStore* store = nullptr;
  std::string path;

  [[nodiscard]] ZarrGroup operator/(const std::string& name) const { return {store, zarr_key(path, name)}; }
  [[nodiscard]] std::string file() const { return store->name() + ": " + path; }
  [[nodiscard]] Json attributes() const { return zarr_attributes(*store, path); }
  [[nodiscard]] bool is_there() const { return is_group(*store, path) || is_array(*store, path); }
};

/// What export_ncore() has left at a component: an object, empty where there is nothing of it.
[[nodiscard]] Json ours_of(const Json& attributes);

class Sequence {
 public:
  /// Opens what `path` names. Error{kInput} for stores that are none of NCore 4, or of several sequences.
  explicit Sequence(const std::filesystem::path& path);
  /// Of one store. Errors as above.
  explicit Sequence(std::unique_ptr<const ZarrStore> store);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  /// Instances of a kind ("cameras"), by name. Error{kInput} for one that is there twice.
  [[nodiscard]] const std::map<std::string, ZarrGroup>& instances(const std::string& kind) const;
  /// Times of the frames of a sensor, in time's order.
  [[nodiscard]] static std::vector<FrameTime> frames(const ZarrGroup& sensor);
  /// The first component of a kind that has this group.
  [[nodiscard]] std::optional<ZarrGroup> find(const std::string& kind, const std::string& group) const;

  [[nodiscard]] const PoseTable& poses() const { return poses_; }
  [[nodiscard]] const Clock& clock() const { return clock_; }
  /// Seconds of stamps; what stands beside them as "time_ns" where a stamp is that, rounded.
  [[nodiscard]] std::vector<double> times_of(const std::vector<std::uint64_t>& stamps,
                                             const Json& ours) const;
  /// As export_ncore() has found them; others behind, by name.
  [[nodiscard]] std::vector<std::string> in_order(const std::string& kind) const;

  /// The path of the rig, where it was told to begin and end. Error{kInput} where there is none.
  struct Path {
    Trajectory trajectory;
    double first_s = 0.0, last_s = 0.0;  // what it covers, beyond its ends, too
  };
  [[nodiscard]] Path path(const std::string& world, const std::string& rig) const;

 private:
  void add(std::unique_ptr<const ZarrStore> store);
  void add_poses();
  void add_components(const ZarrStore& store);

  std::string file_, id_;
  std::vector<std::unique_ptr<const ZarrStore>> stores_;
  std::map<std::string, std::map<std::string, ZarrGroup>> components_;  // by kind and instance
  PoseTable poses_;
  Json ours_;
  Clock clock_;
};

/// Boxes of a sequence as actors, by id in the order of the file. Adds to `unposed` what lies beside the
/// path.
[[nodiscard]] std::vector<Actor> actors_of(const Sequence& sequence,
                                           const Sequence::Path& path,
                                           const std::string& world,
                                           const std::string& rig,
                                           std::size_t& unposed,
                                           LabelReport& report);

/// Rays of a LiDAR's frame, of several returns the first; the others are counted in `echoes`.
[[nodiscard]] RayBundle read_rays(const ZarrGroup& frame, std::size_t& echoes);
/// What of them was exact; empty where the frame doesn't tell.
[[nodiscard]] Exact read_exact(const ZarrGroup& frame);

/// A unit quaternion of four numbers; nothing for anything else.
[[nodiscard]] std::optional<Eigen::Quaterniond> rotation_from(const Json& wxyz);

}  // namespace simuli::ncore
