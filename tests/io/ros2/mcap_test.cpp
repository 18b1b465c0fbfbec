#include <array>
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <tuple>
#include <vector>
#ifdef SIMULI_TEST_SQLITE
#include <sqlite3.h>
#endif

#include "io/bag/bag.hpp"
#include "io/bag/mcap_writer.hpp"
#include "io/base/bytes.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

using Messages = std::vector<std::tuple<std::string, std::string, std::uint64_t, std::string>>;

Messages all_of(const std::filesystem::path& file) {
  Messages messages;
  open_bag(file)->read([](const BagChannel&) { return true; },
                       [&](const BagChannel& channel, std::uint64_t time_ns, std::string_view data) {
                         messages.emplace_back(channel.topic, channel.type, time_ns, std::string(data));
                       });
  return messages;
}

Messages some() {
  Messages messages;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const bool is_a = i % 3 == 0;
    messages.emplace_back(is_a ? "/a" : "/b",
                          is_a ? "p/msg/A" : "p/msg/B",
                          10 * i,
                          std::string(5 * i, static_cast<char>('a' + i)));
  }
  return messages;
}

void write_all(const std::filesystem::path& file, McapWriter::Compression compression) {
  McapWriter writer(file, "ros2", compression, 200);
  std::map<std::string, std::uint16_t> channels;
  for (const auto& [topic, type, time_ns, data] : some()) {
    if (channels.count(topic) == 0)
      channels[topic] = writer.add_channel({topic, type, "ros2msg", "uint8 x\n", "cdr", {{"key", "value"}}});
    writer.add_message(channels[topic], time_ns, data);
  }
  writer.finish();
}

TEST(Mcap, MessagesComeBack) {
  const Scratch scratch;
  write_all(scratch / "plain.mcap", McapWriter::Compression::kNone);
  EXPECT_EQ(all_of(scratch / "plain.mcap"), some());
  if (!has_zstd()) GTEST_SKIP() << "not run: compression, this build has no libzstd";
  write_all(scratch / "zstd.mcap", McapWriter::Compression::kZstd);
  EXPECT_EQ(all_of(scratch / "zstd.mcap"), some());
  EXPECT_EQ(all_of(scratch.path()).size(), 2 * some().size());  // a folder: one after the other
}

TEST(Mcap, NoPartIsTakenForTheWhole) {
  const Scratch scratch;
  write_all(scratch / "a.mcap", McapWriter::Compression::kNone);
  const std::string whole = read_file(scratch / "a.mcap");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    SCOPED_TRACE(size);
    expect_input_error([&] { (void)all_of(scratch.file("cut.mcap", whole.substr(0, size))); }, {"cut.mcap"});
    // Cut inside: the end exists.
    const std::string without = whole.substr(0, size) + whole.substr(std::min(whole.size(), size + 40));
    try {
      EXPECT_EQ(all_of(scratch.file("cut.mcap", without)), some());  // in the summary, which is not needed
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
    }
  }
}

TEST(Mcap, ADamagedByteIsNoticed) {
  const Scratch scratch;
  for (const auto compression : {McapWriter::Compression::kNone, McapWriter::Compression::kZstd}) {
    if (compression == McapWriter::Compression::kZstd && !has_zstd()) continue;
    write_all(scratch / "a.mcap", compression);
    const std::string whole = read_file(scratch / "a.mcap");
    std::size_t refused = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      SCOPED_TRACE(i);
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
      try {
        EXPECT_EQ(all_of(scratch.file("damaged.mcap", damaged)), some());  // outside the data
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kInput);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        ++refused;
      }
    }
    EXPECT_GT(refused, whole.size() / 3);
  }
}

/// Returns a file of one chunk with the given header values.
std::string of_chunk(const std::string& compression, std::uint64_t size, const std::string& records) {
  std::string chunk;
  append_little_endian(chunk, 0, 8);
  append_little_endian(chunk, 0, 8);
  append_little_endian(chunk, size, 8);
  append_little_endian(chunk, 0, 4);
  append_little_endian(chunk, compression.size(), 4);
  chunk += compression;
  append_little_endian(chunk, records.size(), 8);
  chunk += records;
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string file = magic;
  const auto add = [&](char opcode, const std::string& content) {
    file += opcode;
    append_little_endian(file, content.size(), 8);
    file += content;
  };
  add(1, std::string(8, '\0'));
  add(6, chunk);
  add(15, std::string(4, '\0'));
  add(2, std::string(20, '\0'));
  return file + magic;
}

TEST(Mcap, WhatWouldBurstIsRefused) {
  const Scratch scratch;
  const auto refused = [&](const std::string& compression,
                           std::uint64_t size,
                           const std::string& records,
                           const std::vector<std::string>& words) {
    expect_input_error([&] { (void)all_of(scratch.file("a.mcap", of_chunk(compression, size, records))); },
                       words);
  };
  refused("zstd", std::uint64_t{1} << 40U, "abcd", {"uncompressed_size", "at most"});
  refused("zstd", std::uint64_t{1} << 27U, "abcd", {"uncompressed_size", "134217728 bytes in 4"});
  refused("zstd", 16, "abcd", {"a.mcap", "Zstandard"});
  refused("lz4", 16, "abcd", {"a.mcap", "LZ4"});
  refused("brotli", 4, "abcd", {"compression", "zstd, lz4 or none"});
  refused("", 5, "abcd", {"uncompressed_size", "5", "4"});
  refused("", 4, "abcd", {"record", "length"});
}

TEST(Mcap, Lz4IsRead) {
  const Scratch scratch;
  std::string records;  // a message of a missing channel shows that the chunk was unpacked
  records += '\5';
  append_little_endian(records, 22, 8);
  append_little_endian(records, 7, 2);
  records += std::string(20, '\0');
  // A frame's header (independent blocks of at most 64 KB, no checksums), one uncompressed block, the end.
  std::string frame("\x04\x22\x4d\x18\x60\x40\x82", 7);
  append_little_endian(frame, records.size() | 0x80000000U, 4);
  frame += records;
  append_little_endian(frame, 0, 4);
  try {
    EXPECT_EQ(unlz4(frame.data(), frame.size(), records.size(), "a.mcap"), records);
  } catch (const Error& error) {
    if (std::string(error.what()).find("can't read") == std::string::npos) throw;
    GTEST_SKIP() << "not run: LZ4, this build has no liblz4";
  }
  expect_input_error([&] { (void)all_of(scratch.file("a.mcap", of_chunk("lz4", records.size(), frame))); },
                     {"channel_id", "7"});
  expect_input_error([&] { (void)unlz4(frame.data(), frame.size() - 1, records.size(), "a.mcap"); }, {"LZ4"});
  expect_input_error([&] { (void)unlz4(frame.data(), frame.size(), records.size() - 1, "a.mcap"); }, {"LZ4"});
}

TEST(Mcap, WhatIsNoRecordingIsRefused) {
  const Scratch scratch;
  expect_input_error([&] { (void)open_bag(scratch / "absent.mcap"); }, {"absent.mcap"});
  expect_input_error([&] { (void)open_bag(scratch.file("a.bag", "#ROSBAG V2.0\n")); },
                     {".bag", "a bag of ROS 1", "rosbags-convert"});
  expect_input_error([&] { (void)open_bag(scratch.path()); }, {"a bag of ROS 1", "rosbags-convert"});
  std::filesystem::remove(scratch / "a.bag");
  expect_input_error([&] { (void)open_bag(scratch.path()); }, {"no .mcap and no .db3"});
  expect_input_error([&] { (void)open_bag(scratch.file("a.zip", "PK\1\2")); }, {".mcap, .db3"});
  // Files of `ros2 bag record --compression-mode` and others, detected by their first bytes.
  (void)scratch.file("a.mcap.zstd", "\x28\xb5\x2f\xfd");
  expect_input_error([&] { (void)open_bag(scratch.path()); }, {"compressed whole", "unzstd"});
  constexpr const char* kPacked = "compressed whole";
  for (const auto& [name, bytes, found, tool] :
       {std::array{"a.MCAP.gz", "\x1f\x8b", kPacked, "gunzip"},
        {"a.db3.zst", "\x28\xb5\x2f\xfd", kPacked, "unzstd"},
        {"a.mcap.lz4", "\x04\x22\x4d\x18", kPacked, "unlz4"},
        {"a.mcap", "BZh9", kPacked, "bunzip2"},
        {"a.db3", "\3757zXZ", kPacked, "unxz"},
        {"b.mcap", "PK\3\4...", "a zip archive", "unzip"},
        {"b.db3", "#ROSBAG V2.0\n", "a bag of ROS 1", "rosbags-convert"},
        {"c.mcap", "version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS", "git lfs pull"}}) {
    expect_input_error([&, &name = name, &bytes = bytes] { (void)open_bag(scratch.file(name, bytes)); },
                       {name, found, tool});
    std::filesystem::remove(scratch / name);
  }
  expect_input_error([&] { (void)open_bag(scratch.file("A.MCAP", "")); },
                     {"A.MCAP: first 8 bytes: found \"\""});
  expect_input_error([&] { (void)open_bag(scratch.file("A.MCAP", "\x89PNG\r\n\x1a\n")); },
                     {"first 8 bytes: found \"\\x89PNG\\x0d"});
  (void)scratch.file(
      "metadata.yaml",
      "x:\n  relative_file_paths:\n    - a_0.mcap\n    - \"a_1.mcap\"\n  duration:\n    n: 1\n");
  expect_input_error([&] { (void)open_bag(scratch.path()); },
                     {"relative_file_paths", "2 of which 1 files", "without a_0.mcap, a_1.mcap,"});
  // A.MCAP exists: the quotes do not belong to its name.
  for (const char* entries :
       {"    - \"A.MCAP\"\n    - \"a_1.mcap\"\n", "    - 'A.MCAP' \r\n    - a_1.mcap\r\n"}) {
    (void)scratch.file("metadata.yaml",
                       std::string("x:\n  relative_file_paths:\n") + entries + "  duration:\n");
    expect_input_error([&] { (void)open_bag(scratch.path()); },
                       {"2 of which 1 files are there, without a_1.mcap,"});
  }
  for (const char* empty : {"\"\"", "''", "\"", "\" '"}) {
    (void)scratch.file(
        "metadata.yaml",
        std::string("x:\n  relative_file_paths:\n    - ") + empty + "\n    - A.MCAP\n  duration:\n");
    expect_input_error([&] { (void)open_bag(scratch.path()); },
                       {"metadata.yaml: relative_file_paths: found an empty name"});
  }
  (void)scratch.file("metadata.yaml", "x:\n  compression_mode: MESSAGE\n");
  expect_input_error([&] { (void)open_bag(scratch.path()); },
                     {"metadata.yaml", "message", "ros2 bag convert"});
}

#ifdef SIMULI_TEST_SQLITE
void make_database(const std::filesystem::path& file, const std::string& statements) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  sqlite3_close(database);
}

const char kTables[] =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
    " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,"
    " data BLOB NOT NULL);";

TEST(SqliteBag, MessagesComeBack) {
  const Scratch scratch;
  make_database(
      scratch / "a.db3",
      std::string(kTables) +
          "INSERT INTO topics VALUES(1, '/a', 'p/msg/A', 'cdr', '');"
          "INSERT INTO messages VALUES(1, 1, 5, x'000102'); INSERT INTO messages VALUES(2, 1, 6, x'');");
  const Messages expected{{"/a", "p/msg/A", 5, std::string("\0\1\2", 3)}, {"/a", "p/msg/A", 6, ""}};
  EXPECT_EQ(all_of(scratch / "a.db3"), expected);
}

TEST(SqliteBag, WhatIsNoneIsRefused) {
  const Scratch scratch;
  expect_input_error(
      [&] { (void)all_of(scratch.file("a.db3", "no database at all, but long enough for one")); },
      {"a.db3", "topics and messages"});
  make_database(scratch / "b.db3", "CREATE TABLE other(id INTEGER);");
  expect_input_error([&] { (void)all_of(scratch / "b.db3"); }, {"b.db3", "no such table"});
  make_database(scratch / "c.db3", std::string(kTables) + "INSERT INTO messages VALUES(1, 9, 5, x'00');");
  expect_input_error([&] { (void)all_of(scratch / "c.db3"); }, {"c.db3", "topic_id", "9"});
  const std::string whole = read_file(scratch / "c.db3");
  expect_input_error([&] { (void)all_of(scratch.file("d.db3", whole.substr(0, whole.size() / 2))); },
                     {"d.db3"});
}
#endif

}  // namespace
}  // namespace simuli
