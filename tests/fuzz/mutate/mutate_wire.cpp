// Protobuf's wire format, with the lengths that follow from what is in the fields; and TFRecords of it, with
// their checksums.
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/event_file.hpp"
#include "io/base/gzip.hpp"
#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

constexpr int kDeepest = 8;
enum Type : std::uint64_t { kVarint = 0, kFixed64 = 1, kLength = 2, kFixed32 = 5 };

struct Field {
  std::uint64_t tag = 0;    // number << 3 | type
  std::uint64_t value = 0;  // of a varint
  std::string bytes;        // of the others
  [[nodiscard]] std::uint64_t type() const { return tag & 7U; }
};

bool take_varint(const std::string& message, std::size_t& at, std::uint64_t& value) {
  value = 0;
  for (unsigned shift = 0; shift < 64 && at < message.size(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(message[at++]);
    value |= static_cast<std::uint64_t>(byte & 127U) << shift;
    if (byte < 128) return true;
  }
  return false;
}

void append_varint(std::string& out, std::uint64_t value) {
  for (; value >= 128; value >>= 7U) out += static_cast<char>(value | 128U);
  out += static_cast<char>(value);
}

std::optional<std::vector<Field>> fields_of(const std::string& message) {
  std::vector<Field> fields;
  for (std::size_t at = 0; at < message.size();) {
    Field field;
    if (!take_varint(message, at, field.tag) || field.tag < 8) return std::nullopt;
    std::uint64_t bytes = 0;
    switch (field.type()) {
      case kVarint:
        if (!take_varint(message, at, field.value)) return std::nullopt;
        break;
      case kFixed64:
        bytes = 8;
        break;
      case kLength:
        if (!take_varint(message, at, bytes)) return std::nullopt;
        break;
      case kFixed32:
        bytes = 4;
        break;
      default:
        return std::nullopt;
    }
    if (bytes > message.size() - at) return std::nullopt;
    field.bytes = message.substr(at, bytes);
    at += bytes;
    fields.push_back(std::move(field));
  }
  return fields;
}

std::string written(const std::vector<Field>& fields) {
  std::string out;
  for (const Field& field : fields) {
    append_varint(out, field.tag);
    if (field.type() == kVarint) append_varint(out, field.value);
    if (field.type() == kLength) append_varint(out, field.bytes.size());
    out += field.bytes;
  }
  return out;
}

std::optional<std::string> mutated_message(const std::string& message, int depth, Choice& choice);

/// What may be text, numbers in a row, a message, or one of them compressed.
std::string changed_bytes(const std::string& bytes, int depth, Choice& choice) {
  const bool zlib = bytes.size() > 2 && bytes[0] == '\x78';
  if (depth < kDeepest && (is_gzip(bytes) || zlib)) {
    try {
      constexpr std::size_t kMost = std::size_t{1} << 16U;
      return gzip(changed_bytes(gunzip(bytes, "input", kMost), depth + 1, choice));
    } catch (const Error&) {
      return choice.change(bytes);
    }
  }
  if (depth < kDeepest && choice.below(8) != 0) {
    if (std::optional<std::string> changed = mutated_message(bytes, depth + 1, choice)) return *changed;
  }
  return mutated_numbers(bytes, bytes.size() % 8 == 0 ? 8 : 4, choice);
}

std::optional<std::string> mutated_message(const std::string& message, int depth, Choice& choice) {
  std::optional<std::vector<Field>> fields = fields_of(message);
  if (!fields || fields->empty()) return std::nullopt;
  const std::size_t at = choice.below(fields->size());
  Field& field = (*fields)[at];
  switch (choice.below(10)) {
    case 0:
      fields->erase(fields->begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      fields->push_back(Field(field));
      break;
    case 2:
      std::swap(field, (*fields)[choice.below(fields->size())]);
      break;
    case 3:
      field.tag = (1 + choice.below(20)) << 3U | field.type();
      break;
    default:
      if (field.type() == kVarint) {
        const std::uint64_t values[] = {
            0, 1, field.value + 1, field.value - 1, 2147483648U, ~std::uint64_t{0}};
        field.value = values[choice.below(std::size(values))];
      } else if (field.type() == kLength) {
        field.bytes = changed_bytes(field.bytes, depth, choice);
      } else {
        const std::size_t size = field.bytes.size();
        field.bytes = mutated_numbers(field.bytes, size, choice);
        field.bytes.resize(size);
      }
  }
  return written(*fields);
}

/// Bytes of each record; nothing where their lengths don't fit.
std::optional<std::vector<std::string>> records_of(const std::string& file) {
  std::vector<std::string> records;
  for (std::size_t at = 0; at < file.size();) {
    if (file.size() - at < 16) return std::nullopt;
    const auto length = number_at<std::uint64_t>(file, at);
    if (length > file.size() - at - 16) return std::nullopt;
    records.push_back(file.substr(at + 12, length));
    at += 16 + length;
  }
  return records;
}

}  // namespace

std::optional<std::string> mutated_wire(const std::string& message, Choice& choice) {
  return mutated_message(message, 0, choice);
}

std::optional<std::string> mutated_records(const std::string& file, Choice& choice) {
  std::optional<std::vector<std::string>> records = records_of(file);
  if (!records || records->empty()) return std::nullopt;
  const std::size_t at = choice.below(records->size());
  if (choice.below(16) == 0) {
    records->push_back(std::string((*records)[at]));
  } else {
    const std::optional<std::string> changed = mutated_wire((*records)[at], choice);
    if (!changed) return std::nullopt;
    (*records)[at] = *changed;
  }
  std::string out;
  for (const std::string& record : *records) {
    std::string length;
    append_number(length, static_cast<std::uint64_t>(record.size()));
    out += length;
    append_number(out, masked_crc32c(length));
    out += record;
    append_number(out, masked_crc32c(record));
  }
  return out;
}

}  // namespace simuli::test
