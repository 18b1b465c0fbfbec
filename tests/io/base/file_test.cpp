#include "io/base/file.hpp"

#include <gtest/gtest.h>
#include <stdexcept>
#include <sys/stat.h>

#include "io/base/output.hpp"
#include "io/base/state_file.hpp"
#include "io/picture/image.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

std::size_t entries_of(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(File, WritesAndReadsAnyBytes) {
  const Scratch scratch;
  const std::string bytes("a\0b\n\xFF", 5);
  write_file_atomically(scratch / "some.bin", bytes);
  EXPECT_EQ(read_file(scratch / "some.bin"), bytes);
  write_file_atomically(scratch / "some.bin", "");
  EXPECT_EQ(read_file(scratch / "some.bin"), "");
  EXPECT_EQ(entries_of(scratch.path()), 1U);
}

TEST(File, RefusesWhatCannotBeRead) {
  const Scratch scratch;
  expect_input_error([&] { (void)read_file(scratch / "none.txt"); }, {"none.txt", "allowed a readable file"});
  expect_input_error([&] { (void)read_file(scratch.path()); }, {"found a folder", "allowed a file"});
  const fs::path file = scratch.file("five.txt", "12345");
  expect_input_error([&] { (void)read_file(file, 4); },
                     {"five.txt", "size", "found 5 bytes", "allowed at most 4 bytes"});
  EXPECT_EQ(read_file(file, 5), "12345");
}

/// A pipe is neither waited for nor replaced.
TEST(File, APipeIsNoFile) {
  const Scratch scratch;
  const fs::path pipe = scratch / "pipe.png";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_input_error([&] { (void)read_file(pipe); }, {"pipe.png: file: found a pipe, allowed a file"});
  expect_input_error([&] { (void)read_image(pipe); }, {"pipe.png: file: found a pipe, allowed a file"});
  expect_input_error([&] { (void)StateFile(pipe); }, {"pipe.png: file: found a pipe, allowed a file"});
  expect_input_error([&] { write_file_atomically(pipe, "x"); }, {"pipe.png: file: found a pipe"});
  expect_input_error([&] { need_writable(pipe); }, {"pipe.png: file: found a pipe"});
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(entries_of(scratch.path()), 1U);
  EXPECT_NO_THROW(need_regular_file(scratch / "none"));  // its reader reports it
}

TEST(File, RefusesWhereNothingCanBeWritten) {
  const Scratch scratch;
  expect_input_error([&] { write_file_atomically(scratch / "no/such/folder.txt", "x"); },
                     {"folder.txt", "found no folder"});
  fs::create_directory(scratch / "folder");
  expect_input_error([&] { write_file_atomically(scratch / "folder", "x"); }, {"found a folder"});
  EXPECT_EQ(entries_of(scratch.path()), 1U);
}

TEST(File, KeepsTheOldFileWhenWritingFails) {
  const Scratch scratch;
  const fs::path file = scratch.file("picture.png", "old");
  fs::path temporary;
  const auto fail_half_way = [&](const fs::path& path) {
    temporary = path;
    std::ofstream(path) << "half";
    throw std::runtime_error("disk full");
  };
  EXPECT_THROW(write_atomically(file, fail_half_way), std::runtime_error);
  EXPECT_EQ(read_file(file), "old");
  EXPECT_EQ(temporary.extension(), ".png");
  EXPECT_EQ(entries_of(scratch.path()), 1U);
}

TEST(File, RefusesAWriterThatWroteNothing) {
  const Scratch scratch;
  expect_input_error([&] { write_atomically(scratch / "x.png", [](const fs::path&) {}); }, {"sync"});
  EXPECT_EQ(entries_of(scratch.path()), 0U);
}

TEST(Folder, AppearsCompleteOrNotAtAll) {
  const Scratch scratch;
  const auto fill = [&](const fs::path& folder) {
    EXPECT_FALSE(fs::exists(scratch / "a.log"));
    fs::create_directory(folder / "sub");
    std::ofstream(folder / "sub" / "file") << "text";
  };
  write_folder_atomically(scratch / "a.log/", fill);
  EXPECT_EQ(read_file(scratch / "a.log/sub/file"), "text");
  EXPECT_EQ(entries_of(scratch.path()), 1U);

  const auto fail_half_way = [&](const fs::path& folder) {
    std::ofstream(folder / "file") << "text";
    throw std::runtime_error("killed");
  };
  EXPECT_THROW(write_folder_atomically(scratch / "b.log", fail_half_way), std::runtime_error);
  EXPECT_EQ(entries_of(scratch.path()), 1U);
}

TEST(Folder, IsNeverOverwritten) {
  const Scratch scratch;
  fs::create_directory(scratch / "there");
  bool called = false;
  expect_input_error(
      [&] { write_folder_atomically(scratch / "there", [&](const fs::path&) { called = true; }); },
      {"there", "found something of that name", "allowed a path that does not exist"});
  EXPECT_FALSE(called);
}

}  // namespace
}  // namespace simuli
