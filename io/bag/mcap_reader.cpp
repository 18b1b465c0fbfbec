// Reads the data section sequentially and ignores indexes, so that wrong indexes have no effect.
#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/bag/bag.hpp"
#include "io/bag/mcap_format.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using mcap::kMagic;
using mcap::kRecordHead;
using mcap::Opcode;

/// Reads the fields of a record in order; `where` names the record in errors.
class FieldReader {
 public:
  FieldReader(std::string_view bytes, const std::string& file, std::string where)
      : bytes_(bytes), file_(file), where_(std::move(where)) {}

  std::uint64_t number(std::size_t count, const char* field) {
    const std::string_view bytes = take(count, field);
    std::uint64_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[i]);
    return value;
  }
  std::string_view text(const char* field) { return take(number(4, field), field); }
  std::string_view take(std::uint64_t count, const char* field) {
    if (count > bytes_.size()) {
      refuse(field, fmt::format("{} bytes", count), fmt::format("the {} that are left", bytes_.size()));
    }
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  [[nodiscard]] std::string_view rest() const { return bytes_; }
  [[noreturn]] void refuse(const char* field, const std::string& found, const std::string& allowed) const {
    throw_input_error(file_, where_ + ": " + field, found, allowed);
  }

 private:
  std::string_view bytes_;
  const std::string& file_;
  std::string where_;
};

class McapFile : public Bag {
 public:
  explicit McapFile(const fs::path& path) : path_(path), file_(path.string()) {
    need_regular_file(path);
    std::ifstream in(path, std::ios::binary);
    std::string magic(kMagic.size(), '\0');
    if (!in) throw_input_error(file_, "file", "none that can be read", "an MCAP file");
    if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kMagic) {
      magic.resize(static_cast<std::size_t>(in.gcount()));
      throw_input_error(file_, "first 8 bytes", '"' + magic + '"', "those of MCAP, version 0");
    }
    size_ = fs::file_size(path);
    in.seekg(-static_cast<std::streamoff>(kMagic.size()), std::ios::end);
    if (size_ < 2 * kMagic.size() || !in.read(magic.data(), static_cast<std::streamsize>(magic.size())) ||
        magic != kMagic) {
      throw_input_error(file_,
                        "last 8 bytes",
                        "others: cut short, or its recorder was killed",
                        "those of MCAP (the program `mcap recover` saves what is whole)");
    }
  }

  void read(const Wanted& wanted, const OnMessage& on_message) const override;

 private:
  struct Pass {
    const Wanted& wanted;
    const OnMessage& on_message;
    std::map<std::uint16_t, std::string> schemas;  // by schema id
    struct Open {
      BagChannel channel;
      bool is_wanted;
    };
    std::map<std::uint16_t, Open> channels;
  };

  [[nodiscard]] std::string at(std::uint64_t offset) const {
    return fmt::format("record at byte {}", offset);
  }
  void take(Opcode opcode, FieldReader fields, Pass& pass) const;
  void read_chunk(FieldReader chunk, Pass& pass) const;

  fs::path path_;
  std::string file_;
  std::uint64_t size_ = 0;
};

void McapFile::take(Opcode opcode, FieldReader fields, Pass& pass) const {
  if (opcode == Opcode::kSchema) {
    const auto id = static_cast<std::uint16_t>(fields.number(2, "schema's id"));
    pass.schemas[id] = std::string(fields.text("schema's name"));
  } else if (opcode == Opcode::kChannel) {
    const auto id = static_cast<std::uint16_t>(fields.number(2, "channel's id"));
    const auto schema =
        pass.schemas.find(static_cast<std::uint16_t>(fields.number(2, "channel's schema_id")));
    Pass::Open open;
    open.channel.topic = std::string(fields.text("channel's topic"));
    open.channel.type = schema == pass.schemas.end() ? "" : schema->second;
    open.channel.encoding = std::string(fields.text("channel's message_encoding"));
    const auto known = pass.channels.find(id);
    if (known != pass.channels.end()) {
      if (known->second.channel.topic != open.channel.topic)
        fields.refuse("channel's topic", "another than before", "one per channel");
      return;
    }
    open.is_wanted = pass.wanted(open.channel);
    pass.channels.emplace(id, std::move(open));
  } else if (opcode == Opcode::kMessage) {
    const auto id = static_cast<std::uint16_t>(fields.number(2, "message's channel_id"));
    const auto channel = pass.channels.find(id);
    if (channel == pass.channels.end())
      fields.refuse("message's channel_id", fmt::format("{}", id), "a channel above it");
    (void)fields.number(4, "message's sequence");
    const std::uint64_t log_ns = fields.number(8, "message's log_time");
    (void)fields.number(8, "message's publish_time");
    if (channel->second.is_wanted) pass.on_message(channel->second.channel, log_ns, fields.rest());
  }
}

void McapFile::read_chunk(FieldReader chunk, Pass& pass) const {
  (void)chunk.number(8, "chunk's message_start_time");
  (void)chunk.number(8, "chunk's message_end_time");
  const std::uint64_t size = chunk.number(8, "chunk's uncompressed_size");
  if (size > kLargestChunk) {
    chunk.refuse(
        "chunk's uncompressed_size", fmt::format("{} bytes", size), fmt::format("at most {}", kLargestChunk));
  }
  const auto crc = static_cast<std::uint32_t>(chunk.number(4, "chunk's uncompressed_crc"));
  const std::string compression(chunk.text("chunk's compression"));
  const std::string_view packed = chunk.take(chunk.number(8, "chunk's length"), "chunk's records");
  // Upper bound of the decompressed size: blocks of 2^17 bytes from 4 bytes, plus one block.
  const std::uint64_t most = (std::uint64_t{packed.size()} + 4) << 15U;
  if (size > most) {
    chunk.refuse("chunk's uncompressed_size",
                 fmt::format("{} bytes in {}", size, packed.size()),
                 fmt::format("at most {}", most));
  }
  std::string unpacked;
  std::string_view records = packed;
  if (compression == "zstd") {
    records = unpacked = unzstd(packed.data(), packed.size(), size, file_);
  } else if (compression == "lz4") {
    records = unpacked = unlz4(packed.data(), packed.size(), size, file_);
  } else if (!compression.empty()) {
    chunk.refuse(
        "chunk's compression", fmt::format("another of {} letters", compression.size()), "zstd, lz4 or none");
  }
  if (records.size() != size) {
    chunk.refuse("chunk's uncompressed_size", fmt::format("{}", size), fmt::format("{}", records.size()));
  }
  if (crc != 0 && crc_32(records) != crc)
    chunk.refuse("chunk's uncompressed_crc", "that of other bytes", "that of its records: it is damaged");
  FieldReader inside(records, file_, "chunk's record");
  while (!inside.rest().empty()) {
    const auto opcode = static_cast<Opcode>(inside.number(1, "opcode"));
    const std::string_view content = inside.take(inside.number(8, "length"), "content");
    take(opcode, FieldReader(content, file_, "chunk's record"), pass);
  }
}

void McapFile::read(const Wanted& wanted, const OnMessage& on_message) const {
  Pass pass{wanted, on_message, {}, {}};
  std::ifstream in(path_, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(kMagic.size()));
  std::uint32_t crc = crc_32(kMagic);  // of all bytes so far
  const std::uint64_t end = size_ - kMagic.size();
  std::string head(kRecordHead, '\0'), content;
  const auto read_into = [&](std::string& bytes, std::uint64_t offset) {
    if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
      throw_input_error(file_, at(offset), "a read that failed", "a whole file");
  };
  for (std::uint64_t offset = kMagic.size();;) {
    if (end - offset < kRecordHead)
      throw_input_error(file_, at(offset), "the end of the file", "a record: a data end is missing");
    read_into(head, offset);
    FieldReader fields(head, file_, at(offset));
    const auto opcode = static_cast<Opcode>(fields.number(1, "opcode"));
    std::uint64_t left = fields.number(8, "length");
    const std::uint64_t room = end - offset - kRecordHead;
    if (left > room)
      fields.refuse("length", fmt::format("{} bytes", left), fmt::format("the {} that are left", room));
    if (opcode == Opcode{0}) fields.refuse("opcode", "0", "1 to 255");
    if (opcode == Opcode::kFooter) fields.refuse("opcode", "a footer's", "a data end before it");
    offset += kRecordHead + left;
    // indexes, attachments and future record types
    if (opcode > Opcode::kChunk && opcode != Opcode::kDataEnd) {
      crc = crc_32(head, crc);
      for (; left > 0; left -= content.size()) {
        constexpr std::uint64_t kPiece = 1U << 20U;
        content.resize(std::min(left, kPiece));
        read_into(content, offset);
        crc = crc_32(content, crc);
      }
      continue;
    }
    constexpr std::uint64_t kMost =
        kLargestChunk + (1U << 16U);  // a chunk's fields besides its records are small
    if (left > kMost)
      fields.refuse("length", fmt::format("{} bytes", left), fmt::format("at most {}", kMost));
    content.resize(left);
    read_into(content, offset);
    const FieldReader record(content, file_, at(offset - left));
    if (opcode == Opcode::kDataEnd) {
      const auto stated = static_cast<std::uint32_t>(FieldReader(record).number(4, "data_section_crc"));
      if (stated != 0 && stated != crc)
        throw_input_error(
            file_, "data_section_crc", "that of other bytes", "that of its data: it is damaged");
      return;
    }
    crc = crc_32(content, crc_32(head, crc));
    if (opcode == Opcode::kChunk) {
      read_chunk(record, pass);
    } else {
      take(opcode, record, pass);
    }
  }
}

}  // namespace

std::unique_ptr<const Bag> open_mcap(const fs::path& file) { return std::make_unique<const McapFile>(file); }

}  // namespace simuli
