#pragma once
// Strict reading of JSON files: every key is requested by name and type, and an unrequested key is an error, so
// that a misspelt name or a wrong unit ("range_max_cm") is always reported.
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

/// Keys keep the order of the file.
using Json = nlohmann::ordered_json;

/// A JSON object of a file. Every reader throws Error{kInput} "FILE: PATH.KEY: found ..., allowed ..." for a
/// missing key or a value of another type. A nested object is read by a function that receives its JsonObject;
/// keys that the function does not request are an error.
class JsonObject {
 public:
  /// `file` and `path` ("cameras[0]"; empty for the root) appear in messages; `value` must outlive this object.
  JsonObject(std::string file, std::string path, const Json& value);

  [[nodiscard]] const std::string& file() const { return parent_ != nullptr ? parent_->file() : file_; }
  /// Returns "PATH.KEY", for messages of the caller's checks.
  [[nodiscard]] std::string field(const std::string& key) const;
  /// Whether an optional key exists; does not count as a request.
  [[nodiscard]] bool has(const std::string& key) const { return value_.contains(key); }

  /// Returns a number in [minimum, maximum]. JSON has no NaN or Inf.
  [[nodiscard]] double number(const std::string& key,
                              double minimum = std::numeric_limits<double>::lowest(),
                              double maximum = std::numeric_limits<double>::max());
  /// Returns a number without fraction or exponent in [minimum, maximum].
  [[nodiscard]] std::int64_t integer(const std::string& key,
                                     std::int64_t minimum = std::numeric_limits<std::int64_t>::min(),
                                     std::int64_t maximum = std::numeric_limits<std::int64_t>::max());
  /// Returns a text after on_one_line(), because it may be printed.
  [[nodiscard]] std::string text(const std::string& key);
  [[nodiscard]] bool boolean(const std::string& key);
  /// Returns an array of numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& key);
  /// Returns an array of exactly N numbers.
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, 1> vector(const std::string& key) {
    Eigen::Matrix<double, N, 1> values;
    read_numbers(key, values.data(), N);
    return values;
  }
  /// Returns the result of `read(JsonObject&)` for the object under `key`.
  template <class Read>
  [[nodiscard]] auto object(const std::string& key, Read&& read) {
    JsonObject child(file(), field(key), get(key));
    return child.read_and_finish(read);
  }
  /// Returns the result of `read(JsonObject&)` for each object of the array under `key`.
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
  /// Allows unrequested keys, for files of other programs.
  void ignore_other_keys() { ignores_others_ = true; }
  /// Returns the value under `key` unchanged.
  [[nodiscard]] const Json& get(const std::string& key);

  /// Calls `read(*this)`, then refuses keys that it did not request.
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
  /// For elements of long lists: the path is built only when a message needs it.
  JsonObject(const JsonObject& parent, const std::string& key, std::size_t index, const Json& value);
  [[nodiscard]] std::string path() const;
  [[nodiscard]] const Json& array(const std::string& key);
  void read_numbers(const std::string& key, double* values, std::size_t count);
  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const;
  void finish() const;

  const JsonObject* parent_ = nullptr;  // the list path_ of this object contains the element index_
  std::size_t index_ = 0;
  std::string file_;  // empty with a parent
  std::string path_;
  const Json& value_;
  std::vector<std::string> requested_;  // requested keys; few
  bool ignores_others_ = false;
};

/// Parses JSON text. Throws Error{kInput} with line and column for invalid syntax and for a repeated key in an
/// object. `file` appears in messages.
[[nodiscard]] Json parse_json(const std::string& text, const std::string& file);

/// Reads a file whose root is an object and returns the result of `read(JsonObject&)`.
template <class Read>
auto read_json_text(const std::string& text, const std::string& file, Read&& read) {
  const Json root = parse_json(text, file);
  JsonObject object(file, "", root);
  return object.read_and_finish(read);
}

/// Reads a file whose root is an array of objects, one at a time, because tables are large. Errors as in
/// read_json_text(); an error of an entry precedes syntax errors after it.
void read_json_entries(const std::string& text,
                       const std::string& file,
                       const std::function<void(JsonObject&)>& read);

}  // namespace simuli
