#pragma once
// Changes of inputs that keep their form, so that a fuzzer gets past syntax, lengths, compression and
// checksums to what a reader makes of the values.
#include <cstddef>
#include <functional>
#include <optional>
#include <random>
#include <string>

namespace simuli::test {

/// What an input is made of.
enum class Form {
  kBytes,    // anything: left to the fuzzer's own changes
  kText,     // lines of words and numbers
  kJson,     // JSON, or parts of it and of bytes with kBetweenParts between them
  kPly,      // a header's lines, then elements of the sizes that it tells
  kSpz,      // SPZ in gzip, or with Zstandard frames
  kExr,      // attributes, a table of offsets, blocks of lines
  kWire,     // a protobuf message
  kRecords,  // TFRecords of protobuf messages
  kMcap,     // MCAP's records, with messages in CDR
};

inline constexpr char kBetweenParts[] = "%%%%";

/// Where a change's choices come from.
struct Choice {
  std::mt19937 random;
  /// Other bytes instead of these, at most `most` of them: libFuzzer's own change.
  std::function<std::string(const std::string& bytes, std::size_t most)> bytes;

  /// 0 .. count - 1; count > 0.
  [[nodiscard]] std::size_t below(std::size_t count) { return random() % count; }
  /// A number at the edge of something.
  [[nodiscard]] double edge();
  /// Eight bytes more than there are, at most.
  [[nodiscard]] std::string change(const std::string& of) { return bytes(of, of.size() + 8); }
};

/// `input` with one change, in its form again; nothing where it isn't of that form, or kBytes.
[[nodiscard]] std::optional<std::string> mutated(Form form, const std::string& input, Choice& choice);

// Each form by itself.
[[nodiscard]] std::optional<std::string> mutated_text(const std::string& text, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_json(const std::string& text, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_ply(const std::string& file, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_spz(const std::string& file, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_exr(const std::string& file, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_wire(const std::string& message, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_records(const std::string& file, Choice& choice);
[[nodiscard]] std::optional<std::string> mutated_mcap(const std::string& file, Choice& choice);
/// Numbers of a list that stands there in binary (float or double): one at an edge, or the bytes changed.
[[nodiscard]] std::string mutated_numbers(std::string bytes, std::size_t bytes_of_one, Choice& choice);

/// Little endian numbers of a file.
template <class T>
[[nodiscard]] T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  bytes.copy(reinterpret_cast<char*>(&value), sizeof value, at);
  return value;
}
template <class T>
void put_number(std::string& bytes, std::size_t at, T value) {
  bytes.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
void append_number(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace simuli::test
