#pragma once
// Options with keys. Next to each options struct there is one visitor:
//
//   template <class F>
//   constexpr void visit_fields(Options& o, F&& field) {
//     field("voxel_m", o.voxel_m, range(1e-3, 100.0), "m, side of a voxel");    // a number
//     field("shell", o.shell, "place particles of the far shell");              // true or false
//     field("sensors", o.sensors, "that are left out");                         // names separated by commas
//     field("order", o.order, one_of("range", "per_ray"), "of blending");       // an enum
//     field.group("Learning");                                                  // heading of the following
//         fields
//     field.part("camera.", o.camera_rates);                                    // a struct of such fields
//     field.part_in_training("", o.render);                                     // a struct as part of a
//         training
//     field.internal(o.shape);                                                  // not user-settable
//   }
//
// It defines keys, parsing, range checks, help, and the text that identifies a set of options. A member that
// the visitor leaves out is a compile error.
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "host/core/base/allowed.hpp"

namespace simuli {

namespace detail {

/// Converts to any member type of Options, for counting members; never evaluated.
template <class Options>
struct AnyMember {
  template <class T>
  requires(!std::same_as<T, Options>) constexpr operator T() const { return T(); }  // NOLINT: it converts
};

/// Number of members of an aggregate; a nested struct counts as one.
template <class Options, class... Found>
consteval std::size_t member_count() {
  if constexpr (requires { Options{Found{}..., AnyMember<Options>{}}; }) {
    return member_count<Options, Found..., AnyMember<Options>>();
  } else {
    return sizeof...(Found);
  }
}

/// Counts the fields of a visitor.
struct FieldCount {
  std::size_t count = 0;
  template <class... Told>
  constexpr void operator()(const Told&... /*unused*/) {
    ++count;
  }
  constexpr void group(const char* /*unused*/) {}
  template <class Part>
  constexpr void part(const char* /*prefix*/, const Part& /*unused*/) {
    ++count;
  }
  template <class Part>
  constexpr void part_in_training(const char* prefix, const Part& options) {
    part(prefix, options);
  }
  template <class Member>
  constexpr void internal(const Member& /*unused*/) {
    ++count;
  }
};

template <class Options>
consteval std::size_t field_count() {
  Options options{};
  FieldCount counter;
  visit_fields(options, counter);
  return counter.count;
}

}  // namespace detail

/// Whether visit_fields(Options&, ...) visits every member.
template <class Options>
inline constexpr bool kVisitsAllMembers = detail::field_count<Options>() == detail::member_count<Options>();

/// Access to the value of an enum as a number.
struct EnumValue {
  void* at;
  std::size_t (*get)(const void* at);
  void (*set)(void* at, std::size_t value);
};

struct Field {
  std::string key;
  std::variant<double*, int*, std::size_t*, bool*, std::vector<std::string>*, EnumValue> value;
  Allowed range;  // for numbers
  std::vector<std::string> names;  // for an enum's values
  std::string help;                // unit and meaning
  InTraining in_training = InTraining::kAny;
  std::string group = {};  // heading in the help; empty: none

  [[nodiscard]] std::string text() const;  // value as accepted by set()
  [[nodiscard]] std::string allowed() const;  // description of the allowed values
  [[nodiscard]] bool is_sound() const;  // whether the value is allowed
  /// Parses and sets the value; returns false and sets nothing for a value that is not allowed.
  [[nodiscard]] bool set(const std::string& text) const;
};

/// The fields of one or several options structs, which must outlive this.
class Fields {
 public:
  /// Appends the fields of `options` with `prefix` before their keys.
  template <class Options>
  void part(const char* prefix, Options& options) {
    static_assert(kVisitsAllMembers<Options>, "visit_fields() leaves out a member of these options");
    const std::string outer = prefix_, outer_group = group_;
    prefix_ += prefix;
    visit_fields(options, *this);
    prefix_ = outer;
    group_ = outer_group;
  }
  /// Appends fields of options that are part of a training: fields for which trainings only accept the default
  /// are not listed, and other values are rejected by key.
  template <class Options>
  void part_in_training(const char* prefix, Options& options) {
    Fields own, usual;
    Options defaults;
    own.group_ = group_;
    own.part((prefix_ + prefix).c_str(), options);
    usual.part("", defaults);
    for (std::size_t i = 0; i < own.fields_.size(); ++i) {
      if (own.fields_[i].in_training == InTraining::kAny) {
        fields_.push_back(own.fields_[i]);
      } else {
        fixed_.push_back({own.fields_[i], usual.fields_[i].text()});
      }
    }
  }
  // Functions called by visitors; see above. A group ends with its part, or with the next group.
  void group(const char* heading) { group_ = heading; }
  template <class Number>
  void operator()(const char* key,
                  Number& value,
                  const Allowed& allowed,
                  const char* help,
                  InTraining in_training = InTraining::kAny) {
    fields_.push_back({prefix_ + key, &value, allowed, {}, help, in_training, group_});
  }
  void operator()(const char* key, bool& value, const char* help, InTraining in_training = InTraining::kAny) {
    fields_.push_back({prefix_ + key, &value, {}, {}, help, in_training, group_});
  }
  void operator()(const char* key,
                  std::vector<std::string>& value,
                  const char* help,
                  InTraining in_training = InTraining::kAny) {
    fields_.push_back({prefix_ + key, &value, {}, {}, help, in_training, group_});
  }
  template <class Enum, std::size_t N>
  requires std::is_enum_v<Enum>
  void operator()(const char* key,
                  Enum& value,
                  const std::array<const char*, N>& names,
                  const char* help,
                  InTraining in_training = InTraining::kAny) {
    const EnumValue at{&value,
                       [](const void* of) { return static_cast<std::size_t>(*static_cast<const Enum*>(of)); },
                       [](void* of, std::size_t to) { *static_cast<Enum*>(of) = static_cast<Enum>(to); }};
    fields_.push_back({prefix_ + key, at, {}, {names.begin(), names.end()}, help, in_training, group_});
  }
  template <class Member>
  void internal(const Member& /*unused*/) {}

  [[nodiscard]] const std::vector<Field>& all() const { return fields_; }
  [[nodiscard]] const Field* find(const std::string& key) const;  // null: unknown key
  /// Returns the current key of a setting that was renamed, and any other key unchanged.
  [[nodiscard]] static std::string current_key(const std::string& key);

  /// Sets fields from "key=value" lines. Throws Error{kUsage} "WHERE KEY: found, allowed" for a value that is
  /// not allowed, and "WHERE: ..." for an unknown key (with similar keys) or a repeated one. Lines before the
  /// failing one take effect.
  void apply(const std::vector<std::string>& settings, const std::string& where = "--set");
  /// Returns "key=value" lines as accepted by apply(), which identify these options.
  [[nodiscard]] std::vector<std::string> lines() const;
  /// Throws Error{kUsage} "KEY: found, allowed" for the first value outside its range.
  void check() const;
  /// Returns help text by group: "key=value" with the default, allowed values, and the meaning below.
  [[nodiscard]] std::string help() const;

 private:
  /// A field for which trainings only accept the default.
  struct Fixed {
    Field field;
    std::string usual;
    [[nodiscard]] std::string allowed() const;
  };
  [[nodiscard]] std::string known_like(const std::string& key) const;

  std::vector<Field> fields_;
  std::vector<Fixed> fixed_;
  std::string prefix_, group_;
};

template <class Options>
[[nodiscard]] Fields fields_of(Options& options) {
  Fields fields;
  fields.part("", options);
  return fields;
}

/// Fields::lines() and check() for a copy of options.
template <class Options>
[[nodiscard]] std::vector<std::string> lines_of(Options options) {
  return fields_of(options).lines();
}
template <class Options>
void check_fields(Options options) {
  fields_of(options).check();
}

}  // namespace simuli
