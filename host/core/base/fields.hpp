#pragma once
// Options with keys. Beside each options struct stands, once,
//
//   template <class F>
//   constexpr void visit_fields(Options& o, F&& field) {
//     field("voxel_m", o.voxel_m, range(1e-3, 100.0), "m, side of a voxel");    // a number
//     field("shell", o.shell, "place particles of the far shell");              // true or false
//     field("sensors", o.sensors, "that are left out");                         // names, with commas between
//     field("order", o.order, one_of("range", "per_ray"), "of blending");       // an enum
//     field.group("Learning");                                                  // heads what follows in the help
//     field.part("camera.", o.camera_rates);                                    // a struct of such fields
//     field.part_in_training("", o.render);                                     // of a training
//     field.internal(o.shape);                                                   // nothing that users set
//   }
//
// and from it come keys, parsing, range checks, help and the text that tells
// one set of options from another. A member that the visitor leaves out is a compile error where the fields
// are asked for.
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

/// Stands for any member of Options when they are counted; never evaluated.
template <class Options>
struct AnyMember {
  template <class T>
  requires(!std::same_as<T, Options>) constexpr operator T() const { return T(); }  // NOLINT: it converts
};

/// Members of an aggregate, a nested struct counting as one.
template <class Options, class... Found>
consteval std::size_t member_count() {
  if constexpr (requires { Options{Found{}..., AnyMember<Options>{}}; }) {
    return member_count<Options, Found..., AnyMember<Options>>();
  } else {
    return sizeof...(Found);
  }
}

/// Counts what a visitor tells of.
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

/// True where visit_fields(Options&, ...) tells of every member.
template <class Options>
inline constexpr bool kVisitsAllMembers = detail::field_count<Options>() == detail::member_count<Options>();

/// Where the value of an enum is, and how it is read and written as a number.
struct EnumValue {
  void* at;
  std::size_t (*get)(const void* at);
  void (*set)(void* at, std::size_t value);
};

struct Field {
  std::string key;
  std::variant<double*, int*, std::size_t*, bool*, std::vector<std::string>*, EnumValue> value;
  Allowed range;                   // of numbers
  std::vector<std::string> names;  // of an enum's values
  std::string help;                // unit and meaning
  InTraining in_training = InTraining::kAny;
  std::string group = {};  // heading that it stands below in the help; empty: none

  [[nodiscard]] std::string text() const;     // of the value: what set() takes
  [[nodiscard]] std::string allowed() const;  // values, in words
  [[nodiscard]] bool is_sound() const;        // the value is one of those
  /// The value from its text; false, and nothing set, for what is not allowed.
  [[nodiscard]] bool set(const std::string& text) const;
};

/// The fields of one or several options structs, which must outlive this.
class Fields {
 public:
  /// Appends those of `options`, `prefix` before their keys.
  template <class Options>
  void part(const char* prefix, Options& options) {
    static_assert(kVisitsAllMembers<Options>, "visit_fields() leaves out a member of these options");
    const std::string outer = prefix_, outer_group = group_;
    prefix_ += prefix;
    visit_fields(options, *this);
    prefix_ = outer;
    group_ = outer_group;
  }
  /// The same of options that a training has: fields of which it takes the default alone are refused by
  /// their own key where they are set to something else, and are not listed.
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
  // What visitors call; see above. A group ends with the part that names it, or with the next one.
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
  [[nodiscard]] const Field* find(const std::string& key) const;  // null: no such key
  /// Returns the current key of a setting that was renamed, and any other key unchanged.
  [[nodiscard]] static std::string current_key(const std::string& key);

  /// Sets fields from "key=value" lines. Error{kUsage} reading "WHERE KEY: found, allowed" for a value that
  /// is not one of the key's, "WHERE: ..." for a key that is not there (naming those that resemble it) or
  /// stands twice. What stood before the bad line is set.
  void apply(const std::vector<std::string>& settings, const std::string& where = "--set");
  /// "key=value" of each, which apply() takes: the text that tells these options from others.
  [[nodiscard]] std::vector<std::string> lines() const;
  /// Error{kUsage} "KEY: found, allowed" for the first value outside its range.
  void check() const;
  /// For people, group by group: "key=value" (as the default), allowed values, and below them the meaning.
  [[nodiscard]] std::string help() const;

 private:
  /// A field of which a training takes the default alone.
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

/// Fields::lines() and check() of options that nobody changes.
template <class Options>
[[nodiscard]] std::vector<std::string> lines_of(Options options) {
  return fields_of(options).lines();
}
template <class Options>
void check_fields(Options options) {
  fields_of(options).check();
}

}  // namespace simuli
