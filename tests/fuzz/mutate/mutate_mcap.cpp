// MCAP's records, of the data section and of chunks that are not compressed: changed one at a time, with
// lengths and sizes that fit, and no checksums.
#include <string_view>
#include <vector>

#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr char kMessage = 5, kChunk = 6, kDataEnd = 15;
constexpr std::size_t kMessageHead = 2 + 4 + 8 + 8, kCdrHead = 4;

struct Record {
  char opcode;
  std::string content;
};

std::optional<std::vector<Record>> records_of(std::string_view bytes) {
  std::vector<Record> records;
  while (!bytes.empty()) {
    if (bytes.size() < 9) return std::nullopt;
    const auto length = number_at<std::uint64_t>(std::string(bytes.substr(1, 8)), 0);
    if (length > bytes.size() - 9) return std::nullopt;
    records.push_back({bytes[0], std::string(bytes.substr(9, length))});
    bytes.remove_prefix(9 + length);
  }
  return records;
}

std::string written(const std::vector<Record>& records) {
  std::string out;
  for (const Record& record : records) {
    out += record.opcode;
    append_number(out, static_cast<std::uint64_t>(record.content.size()));
    out += record.content;
  }
  return out;
}

/// Behind the message's own fields CDR: counts, lengths and floats at multiples of four, doubles at those of
/// eight.
std::string mutated_message(const std::string& content, Choice& choice) {
  if (content.size() < kMessageHead + kCdrHead || choice.below(8) == 0) return choice.change(content);
  const std::size_t head = kMessageHead + kCdrHead;
  std::string cdr = content.substr(head);
  if (cdr.size() >= 4 && choice.below(2) == 0) {
    const std::size_t at = 4 * choice.below(cdr.size() / 4);
    constexpr std::uint32_t kCounts[] = {0, 1, 2, 3, 5, 8, 0x7fffffffU, 0xffffffffU, 65536, 65537};
    put_number(cdr, at, kCounts[choice.below(std::size(kCounts))]);
  } else {
    cdr = mutated_numbers(cdr, choice.below(2) == 0 ? sizeof(float) : sizeof(double), choice);
  }
  return content.substr(0, head) + cdr;
}

bool mutate(std::vector<Record>& records, int depth, Choice& choice) {
  if (records.empty()) return false;
  const std::size_t at = choice.below(records.size());
  Record& record = records[at];
  if (choice.below(16) == 0) {
    records.insert(records.begin() + static_cast<std::ptrdiff_t>(choice.below(records.size())),
                   Record(record));
    return true;
  }
  constexpr std::size_t kChunkHead = 8 + 8 + 8 + 4 + 4 + 8;  // of one without compression
  if (record.opcode == kChunk && depth == 0 && record.content.size() > kChunkHead &&
      number_at<std::uint32_t>(record.content, 28) == 0) {
    auto inside = records_of(std::string_view(record.content).substr(kChunkHead));
    if (inside && mutate(*inside, 1, choice)) {
      const std::string bytes = written(*inside);
      record.content.resize(kChunkHead);
      put_number(record.content, 16, static_cast<std::uint64_t>(bytes.size()));
      put_number(record.content, 24, std::uint32_t{0});
      put_number(record.content, kChunkHead - 8, static_cast<std::uint64_t>(bytes.size()));
      record.content += bytes;
      return true;
    }
  }
  record.content =
      record.opcode == kMessage ? mutated_message(record.content, choice) : choice.change(record.content);
  return true;
}

}  // namespace

std::optional<std::string> mutated_mcap(const std::string& file, Choice& choice) {
  if (file.size() < 2 * kMagic.size() || !file.starts_with(kMagic) || !file.ends_with(kMagic))
    return std::nullopt;
  auto records = records_of(std::string_view(file).substr(kMagic.size(), file.size() - 2 * kMagic.size()));
  if (!records || !mutate(*records, 0, choice)) return std::nullopt;
  for (Record& record : *records) {
    if (record.opcode == kDataEnd && record.content.size() >= 4)
      put_number(record.content, 0, std::uint32_t{0});
  }
  return std::string(kMagic) + written(*records) + std::string(kMagic);
}

}  // namespace simuli::test
