#include "io/bag/mcap_writer.hpp"

#include <algorithm>
#include <limits>

#include "host/core/base/error.hpp"
#include "host/core/base/version.hpp"
#include "io/bag/mcap_format.hpp"
#include "io/base/bytes.hpp"
#include "io/base/gzip.hpp"

namespace simuli {
namespace {

using mcap::Opcode;

/// Appends the fields of one record.
class FieldWriter {
 public:
  FieldWriter& u16(std::uint64_t value) { return number(value, 2); }
  FieldWriter& u32(std::uint64_t value) { return number(value, 4); }
  FieldWriter& u64(std::uint64_t value) { return number(value, 8); }
  FieldWriter& text(std::string_view value) {
    u32(value.size());
    return bytes(value);
  }
  FieldWriter& bytes(std::string_view value) {
    bytes_ += value;
    return *this;
  }
  template <class Add>
  FieldWriter& list(const Add& add) {
    FieldWriter inner;
    add(inner);
    return text(inner.bytes_);
  }
  /// Returns the record with opcode and length.
  [[nodiscard]] std::string as(Opcode opcode) const {
    FieldWriter record;
    record.number(static_cast<std::uint64_t>(opcode), 1).u64(bytes_.size()).bytes(bytes_);
    return record.bytes_;
  }

 private:
  FieldWriter& number(std::uint64_t value, int count) {
    append_little_endian(bytes_, value, count);
    return *this;
  }
  std::string bytes_;
};

}  // namespace

McapWriter::McapWriter(std::filesystem::path file,
                       const std::string& profile,
                       Compression compression,
                       std::size_t chunk_bytes)
    : file_(std::move(file)),
      out_(file_, std::ios::binary | std::ios::trunc),
      compression_(compression),
      chunk_bytes_(chunk_bytes) {
  if (compression_ == Compression::kZstd && !has_zstd()) (void)zstd("");  // throws the error
  write(mcap::kMagic);
  write(FieldWriter().text(profile).text(std::string("simuli-cl ") + version()).as(Opcode::kHeader));
}

void McapWriter::write(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw_input_error(file_.string(), "file", "a write that failed", "a place with room for it");
  crc_ = crc_32(bytes, crc_);
  written_ += bytes.size();
}

std::uint16_t McapWriter::add_channel(const Channel& channel) {
  if (counts_.size() >= std::numeric_limits<std::uint16_t>::max())
    throw Error(ErrorKind::kInternal, "mcap: more channels than there are numbers");
  std::uint16_t& schema = schema_ids_[channel.schema];
  if (schema == 0) {
    schema = static_cast<std::uint16_t>(schema_ids_.size());
    const std::string record = FieldWriter()
                                   .u16(schema)
                                   .text(channel.schema)
                                   .text(channel.encoding)
                                   .text(channel.definition)
                                   .as(Opcode::kSchema);
    schemas_ += record;
    chunk_ += record;
  }
  const auto id = static_cast<std::uint16_t>(counts_.size());
  counts_.push_back(0);
  const std::string record = FieldWriter()
                                 .u16(id)
                                 .u16(schema)
                                 .text(channel.topic)
                                 .text(channel.message_encoding)
                                 .list([&](FieldWriter& map) {
                                   for (const auto& [key, value] : channel.metadata)
                                     map.text(key).text(value);
                                 })
                                 .as(Opcode::kChannel);
  channels_ += record;
  chunk_ += record;
  return id;
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data) {
  std::uint64_t& count = counts_.at(channel);
  chunk_times_[channel].emplace_back(time_ns, chunk_.size());
  chunk_ += FieldWriter().u16(channel).u32(count).u64(time_ns).u64(time_ns).bytes(data).as(Opcode::kMessage);
  ++count;
  if (chunk_.size() >= chunk_bytes_) close_chunk();
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{std::numeric_limits<std::uint64_t>::max(), 0, written_, 0, 0, 0, chunk_.size(), {}};
  for (const auto& [channel, times] : chunk_times_) {
    for (const auto& [time_ns, offset] : times) {
      index.first_ns = std::min(index.first_ns, time_ns);
      index.last_ns = std::max(index.last_ns, time_ns);
    }
  }
  index.first_ns = std::min(index.first_ns, index.last_ns);  // 0 for a chunk without messages
  const std::uint32_t crc = crc_32(chunk_);
  if (compression_ == Compression::kZstd) chunk_ = zstd(chunk_);
  index.compressed = chunk_.size();
  write(FieldWriter()
            .u64(index.first_ns)
            .u64(index.last_ns)
            .u64(index.size)
            .u32(crc)
            .text(compression_ == Compression::kZstd ? "zstd" : "")
            .u64(chunk_.size())
            .bytes(chunk_)
            .as(Opcode::kChunk));
  index.length = written_ - index.start;
  for (const auto& [channel, times] : chunk_times_) {
    index.index_offsets[channel] = written_;
    const auto add = [&in_chunk = times](FieldWriter& list) {
      for (const auto& [time_ns, offset] : in_chunk) list.u64(time_ns).u64(offset);
    };
    write(FieldWriter().u16(channel).list(add).as(Opcode::kMessageIndex));
  }
  index.index_length = written_ - index.start - index.length;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_times_.clear();
}

std::string McapWriter::statistics() const {
  std::uint64_t messages = 0, first_ns = 0, last_ns = 0;
  for (const std::uint64_t count : counts_) messages += count;
  for (const ChunkIndex& chunk : chunks_) {
    if (chunk.index_offsets.empty()) continue;
    first_ns = first_ns == 0 ? chunk.first_ns : std::min(first_ns, chunk.first_ns);
    last_ns = std::max(last_ns, chunk.last_ns);
  }
  return FieldWriter()
      .u64(messages)
      .u16(schema_ids_.size())
      .u32(counts_.size())
      .u32(0)  // number of attachments
      .u32(0)  // number of metadata records
      .u32(chunks_.size())
      .u64(first_ns)
      .u64(last_ns)
      .list([this](FieldWriter& map) {
        for (std::size_t i = 0; i < counts_.size(); ++i) map.u16(i).u64(counts_[i]);
      })
      .as(Opcode::kStatistics);
}

void McapWriter::finish() {
  close_chunk();
  write(FieldWriter().u32(crc_).as(Opcode::kDataEnd));
  std::string chunk_indexes;
  for (const ChunkIndex& c : chunks_) {
    chunk_indexes += FieldWriter()
                         .u64(c.first_ns)
                         .u64(c.last_ns)
                         .u64(c.start)
                         .u64(c.length)
                         .list([&](FieldWriter& map) {
                           for (const auto& [channel, offset] : c.index_offsets) map.u16(channel).u64(offset);
                         })
                         .u64(c.index_length)
                         .text(compression_ == Compression::kZstd ? "zstd" : "")
                         .u64(c.compressed)
                         .u64(c.size)
                         .as(Opcode::kChunkIndex);
  }
  const std::uint64_t summary_start = written_;
  crc_ = 0;
  std::string offsets;
  const auto add_group = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    const std::string code(1, static_cast<char>(opcode));
    offsets += FieldWriter().bytes(code).u64(written_).u64(records.size()).as(Opcode::kSummaryOffset);
    write(records);
  };
  add_group(Opcode::kSchema, schemas_);
  add_group(Opcode::kChannel, channels_);
  add_group(Opcode::kStatistics, statistics());
  add_group(Opcode::kChunkIndex, chunk_indexes);
  const std::uint64_t offsets_start = written_;
  write(offsets);
  // The checksum covers the footer's fields before the checksum as well.
  std::string footer = FieldWriter().u64(summary_start).u64(offsets_start).u32(0).as(Opcode::kFooter);
  footer.resize(footer.size() - 4);
  write(footer);
  write(FieldWriter().u32(crc_).as(Opcode::kFooter).substr(mcap::kRecordHead));
  write(mcap::kMagic);
  out_.close();
  if (!out_) throw_input_error(file_.string(), "file", "a write that failed", "a place with room for it");
}

}  // namespace simuli
