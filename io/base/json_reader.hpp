#pragma once
// Strict reading of JSON files: every key is asked for by name and type, and a key that nobody asked for
// is an error, so that a misspelt name or a wrong unit ("range_max_cm") never passes silently.
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace simuli {

/// Keys keep the order in which they are written.
using Json = nlohmann::ordered_json;

/// One JSON object of a file. Every reader throws Error{kInput} "FILE: PATH.KEY: found ..., allowed ..."
/// for a missing key or a value of another type. Nested objects are read by a function that gets their
/// JsonObject; when it returns, keys it did not ask for are an error.
class JsonObject {
 public:
  /// `file` and `path` ("cameras[0]"; empty for the root) are for messages; `value` must outlive this.
  JsonObject(std::string file, std::string path, const Json& value);

  [[nodiscard]] const std::string& file() const { return parent_ != nullptr ? parent_->file() : file_; }
  /// "PATH.KEY", for messages of checks made by the caller.
  [[nodiscard]] std::string field(const std::string& key) const;
  /// Whether an optional key is there (does not count as asking for it).
  [[nodiscard]] bool has(const std::string& key) const { return value_.contains(key); }

  /// A number in [minimum, maximum] (JSON has no NaN or Inf).
  [[nodiscard]] double number(const std::string& key,
                              double minimum = std::numeric_limits<double>::lowest(),
                              double maximum = std::numeric_limits<double>::max());
  /// A number without fraction or exponent in [minimum, maximum].
  [[nodiscard]] std::int64_t integer(const std::string& key,
                                     std::int64_t minimum = std::numeric_limits<std::int64_t>::min(),
                                     std::int64_t maximum = std::numeric_limits<std::int64_t>::max());
  /// As on_one_line() has it: it is shown to people, by whoever.
  [[nodiscard]] std::string text(const std::string& key);
  [[nodiscard]] bool boolean(const std::string& key);
  /// An array of numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& key);
  /// An array of exactly N numbers.
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, 1> vector(const std::string& key) {
    Eigen::Matrix<double, N, 1> values;
    read_numbers(key, values.data(), N);
    return values;
  }
  /// What `read(JsonObject&)` makes of the object under `key`.
  template <class Read>
  [[nodiscard]] auto object(const std::string& key, Read&& read) {
    JsonObject child(file(), field(key), get(key));
    return child.read_and_finish(read);
  }
  /// What `read(JsonObject&)` makes of each object of the array under `key`.
  template <class Read>
  [[nodiscard]] auto objects(const std::string& key, Read&& read) {
    std::vector<std::decay_t<std::invoke_result_t<Read&, JsonObject&>>> out;
    const Json& elements = array(key);
    out.reserve(elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) {
      JsonObject child(*this, key, i, elements[i]);
      out.push_back(child.read_and_finish(read));
    }
    return out;
  }
  /// Allows a key without reading it, for files of other programs that hold more than is needed.
  void ignore_other_keys() { ignores_others_ = true; }
  /// The value under `key` as it stands.
  [[nodiscard]] const Json& get(const std::string& key);

  /// Calls `read(*this)`, then refuses keys that it did not ask for.
  template <class Read>
  auto read_and_finish(Read&& read) {
    if constexpr (std::is_void_v<std::invoke_result_t<Read&, JsonObject&>>) {
      read(*this);
      finish();
    } else {
      auto result = read(*this);
      finish();
      return result;
    }
  }

 private:
  /// Of a list as long as a file: what messages alone need is made once there is one.
  JsonObject(const JsonObject& parent, const std::string& key, std::size_t index, const Json& value);
  [[nodiscard]] std::string path() const;
  [[nodiscard]] const Json& array(const std::string& key);
  void read_numbers(const std::string& key, double* values, std::size_t count);
  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const;
  void finish() const;

  const JsonObject* parent_ = nullptr;  // where this is the element index_ of its list path_
  std::size_t index_ = 0;
  std::string file_;  // empty with a parent
  std::string path_;
  const Json& value_;
  std::vector<std::string> asked_;  // few
  bool ignores_others_ = false;
};

/// Parses JSON text; Error{kInput} with line and column for bad syntax, and for a key that stands twice in
/// one object. `file` is for messages.
[[nodiscard]] Json parse_json(const std::string& text, const std::string& file);

/// Reads a file whose root is an object: what `read(JsonObject&)` makes of it.
template <class Read>
auto read_json_text(const std::string& text, const std::string& file, Read&& read) {
  const Json root = parse_json(text, file);
  JsonObject object(file, "", root);
  return object.read_and_finish(read);
}

/// Reads a file whose root is an array of objects, each forgotten before the next one: tables are large.
/// Errors as of read_json_text(), one of an entry before one of what stands behind it.
void read_json_entries(const std::string& text,
                       const std::string& file,
                       const std::function<void(JsonObject&)>& read);

}  // namespace simuli
