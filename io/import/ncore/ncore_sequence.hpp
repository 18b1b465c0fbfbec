#pragma once
// The stores of an NCore sequence and their content, for io/import/ncore/*.cpp and tests.
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

/// Returns the data of export_ncore() at a component: an object, possibly empty.
[[nodiscard]] Json ours_of(const Json& attributes);

class Sequence {
 public:
  /// Opens the stores of `path`. Throws Error{kInput} for stores that are not NCore 4, and for several
  /// sequences.
  explicit Sequence(const std::filesystem::path& path);
  /// Opens one store. Errors as above.
  explicit Sequence(std::unique_ptr<const ZarrStore> store);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  /// Returns the instances of a kind ("cameras") by name. Throws Error{kInput} for a repeated name.
  [[nodiscard]] const std::map<std::string, ZarrGroup>& instances(const std::string& kind) const;
  /// Returns a sensor's frames in time order.
  [[nodiscard]] static std::vector<FrameTime> frames(const ZarrGroup& sensor);
  /// Returns the first component of a kind with this group.
  [[nodiscard]] std::optional<ZarrGroup> find(const std::string& kind, const std::string& group) const;

  [[nodiscard]] const PoseTable& poses() const { return poses_; }
  [[nodiscard]] const Clock& clock() const { return clock_; }
  /// Converts stamps to seconds, or returns the exact "time_ns" stored beside them if the stamp is its rounded
  /// form.
  [[nodiscard]] std::vector<double> times_of(const std::vector<std::uint64_t>& stamps,
                                             const Json& ours) const;
  /// Returns the names in the order stored by export_ncore(), followed by the others in alphabetical order.
  [[nodiscard]] std::vector<std::string> in_order(const std::string& kind) const;

  /// The rig's trajectory with its stored begin and end. Throws Error{kInput} if there is none.
  struct Path {
    Trajectory trajectory;
    double first_s = 0.0, last_s = 0.0;  // valid times, also beyond the first and last pose
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

/// Returns the boxes of a sequence as actors, by id in file order. Adds the number of boxes outside the
/// trajectory to `unposed`.
[[nodiscard]] std::vector<Actor> actors_of(const Sequence& sequence,
                                           const Sequence::Path& path,
                                           const std::string& world,
                                           const std::string& rig,
                                           std::size_t& unposed,
                                           LabelReport& report);

/// Returns the rays of a LiDAR's frame with their first returns; `echoes` counts further returns.
[[nodiscard]] RayBundle read_rays(const ZarrGroup& frame, std::size_t& echoes);
/// Returns the exact values of rays; empty if the frame has none.
[[nodiscard]] Exact read_exact(const ZarrGroup& frame);

/// Returns a unit quaternion of four numbers; no value otherwise.
[[nodiscard]] std::optional<Eigen::Quaterniond> rotation_from(const Json& wxyz);

}  // namespace simuli::ncore
