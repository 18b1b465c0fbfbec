#pragma once
// Serialises scenes and drive data to bytes and back with the same bits, for files read by the same build.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Writes values, or reads them in the same order.
class Packed {
 public:
  Packed() = default;
  /// Reads the bytes of another object. `file` and `name`: their origin, for errors.
  Packed(std::vector<std::byte> bytes, std::string file, std::string name)
      : bytes_(std::move(bytes)), file_(std::move(file)), name_(std::move(name)), gives_(true) {}

  /// Throws Error{kInput} when too few bytes are left.
  template <class... Values>
  void operator()(Values&... values) {
    (pack(*this, values), ...);
  }
  /// Processes all members of a struct; a missing member is a compile error.
  template <class Struct, class... Members>
  void all(const Struct& /*type*/, Members&... members) {
    static_assert(detail::member_count<Struct>() == sizeof...(Members), "a member is left out");
    (*this)(members...);
  }
  template <class Value>
  void raw(Value* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<Value>);
    if (count == 0) return;
    if (gives_) {
      need(count, sizeof(Value));
      std::memcpy(values, bytes_.data() + at_, count * sizeof(Value));
      at_ += count * sizeof(Value);
    } else {
      const auto* const from = reinterpret_cast<const std::byte*>(values);
      bytes_.insert(bytes_.end(), from, from + count * sizeof(Value));
    }
  }
  /// Reads or writes the number of following elements, of at least `each` bytes.
  [[nodiscard]] std::size_t count(std::size_t own, std::size_t each) {
    raw(&own, 1);
    if (gives_) need(own, each);
    return own;
  }
  [[nodiscard]] bool gives() const { return gives_; }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  /// Throws Error{kInput} when bytes are left.
  void need_end() const {
    if (at_ != bytes_.size()) throw_input_error(file_, name_, "more values", "those of this build");
  }

 private:
  void need(std::size_t count, std::size_t each) const {
    if (count > (bytes_.size() - at_) / each) {
      throw_input_error(file_, name_, "fewer values", "those of this build");
    }
  }

  std::vector<std::byte> bytes_;
  std::string file_, name_;
  std::size_t at_ = 0;
  bool gives_ = false;
};

template <class Value>
concept HasFields = requires(Value& value, detail::FieldCount& visitor) {
  visit_fields(value, visitor);
};

template <class Value>
requires(std::is_trivially_copyable_v<Value> && !HasFields<Value>) void pack(Packed& p, Value& value) {
  p.raw(&value, 1);
}

inline void pack(Packed& p, std::string& text) {
  text.resize(p.count(text.size(), 1));
  p.raw(text.data(), text.size());
}

template <class Value>
void pack(Packed& p, std::vector<Value>& values) {
  values.resize(p.count(values.size(), std::is_arithmetic_v<Value> ? sizeof(Value) : 1));
  if constexpr (std::is_arithmetic_v<Value>) {
    p.raw(values.data(), values.size());
  } else {
    for (Value& value : values) p(value);
  }
}

template <class Scalar, int kRows, int kColumns>
void pack(Packed& p, Eigen::Matrix<Scalar, kRows, kColumns>& matrix) {
  if constexpr (kRows == Eigen::Dynamic) {
    Eigen::Index columns = matrix.cols();
    const auto size =
        static_cast<Eigen::Index>(p.count(static_cast<std::size_t>(matrix.size()), sizeof(Scalar)));
    p(columns);
    matrix.resize(columns > 0 ? size / columns : 0, columns);
  }
  p.raw(matrix.data(), static_cast<std::size_t>(matrix.size()));
}

template <class... Kinds>
void pack(Packed& p, std::variant<Kinds...>& value) {
  std::size_t kind = value.index(), next = 0;
  p(kind);
  ((next++ == kind && value.index() != kind ? static_cast<void>(value.template emplace<Kinds>()) : void()),
   ...);
  std::visit(p, value);
}

/// Packs the fields of visit_fields(), including internal ones.
struct PackFields {
  Packed& p;
  void group(const char* /*heading*/) const {}
  void part(const char* /*prefix*/, auto& options) const { p(options); }
  void part_in_training(const char* /*prefix*/, auto& options) const { p(options); }
  void internal(auto& value) const { p(value); }
  void operator()(const char* /*key*/, auto& value, const auto&... /*told*/) const { p(value); }
};
template <HasFields Options>
void pack(Packed& p, Options& options) {
  static_assert(kVisitsAllMembers<Options>, "visit_fields() leaves out a member of these options");
  visit_fields(options, PackFields{p});
}

// All members of each struct: a structured binding with another number of names does not compile.
inline void pack(Packed& p, Pose& v) { p.all(v, v.rotation.coeffs(), v.translation); }
inline void pack(Packed& p, TimedPose& v) { p.all(v, v.time_s, v.pose); }
/// Packs poses directly: reconstruction would normalise them again and change bits.
inline void pack(Packed& p, Trajectory& v) { p(const_cast<std::vector<TimedPose>&>(v.poses())); }
inline void pack(Packed& p, KeyPose& v) { p.all(v, v.time_s, v.world_from_actor, v.shift_m, v.turn_rad); }
inline void pack(Packed& p, Deformation& v) { p.all(v, v.nodes, v.start_s, v.interval_s, v.offsets_m); }
inline void pack(Packed& p, Actor& v) { p.all(v, v.name, v.kind, v.size_m, v.track, v.deformation); }

inline void pack(Packed& p, BlindArc& v) { p.all(v, v.row, v.azimuth_first, v.azimuth_last, v.own_returns); }
inline void pack(Packed& p, Lidar& v) {
  auto& [a, b, c, d, e, f, g, h, i, j, k, l] = v;
  p(a, b, c, d, e, f, g, h, i, j, k, l);
}
inline void pack(Packed& p, RayList& v) {
  auto& [a, b, c, d, e, f, g, h, i, j] = v;
  p(a, b, c, d, e, f, g, h, i, j);
}
inline void pack(Packed& p, LogLidar& v) { p.all(v, v.model, v.rig_from_lidar); }

/// The parts of a log that initialisation changes.
inline void pack(Packed& p, Log& v) { p(v.lidars, v.world_from_rig, v.actors); }

inline void pack(Packed& p, GaussianSet& v) { p(v.kind, v.sh_degree, v.params, v.actor); }
inline void pack(Packed& p, EnvironmentMap& v) { p.all(v, v.width, v.height, v.texels); }
inline void pack(Packed& p, ColorGrids::Frame& v) { p.all(v, v.camera, v.time_s); }
/// aim_color_grids() recomputes the other members.
inline void pack(Packed& p, ColorGrids& v) { p(v.size_x, v.size_y, v.size_z, v.frames, v.values); }
inline void pack(Packed& p, VisibilitySet& v) { p.all(v, v.path_m, v.occluders); }
inline void pack(Packed& p, RayDrop& v) { p.all(v, v.lidar, v.parameters); }
inline void pack(Packed& p, Scene& v) {
  auto& [a, b, c, d, e, f, g, h, i, j, k, l, m] = v;
  p(a, b, c, d, e, f, g, h, i, j, k, l, m);
}

}  // namespace simuli
