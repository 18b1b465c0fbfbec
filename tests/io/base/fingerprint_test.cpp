#include "io/base/fingerprint.hpp"

#include <chrono>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "io/base/file.hpp"
#include "io/base/output.hpp"
#include "io/base/temporary.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

TEST(Fingerprint, TellsEveryChange) {
  const Scratch scratch;
  EXPECT_EQ(fingerprint(scratch / "x"), "");
  fs::create_directories(scratch / "x/deep");
  write_file_atomically(scratch / "x/a", "one");
  write_file_atomically(scratch / "x/deep/b", "two");
  const std::string first = fingerprint(scratch / "x");
  EXPECT_EQ(first.rfind("2 files, 6 bytes, ", 0), 0U) << first;
  EXPECT_EQ(fingerprint(scratch / "x/"), first);

  const auto expect_other = [&](const char* what) { EXPECT_NE(fingerprint(scratch / "x"), first) << what; };
  const auto time = fs::last_write_time(scratch / "x/deep/b");
  fs::last_write_time(scratch / "x/deep/b", time + std::chrono::microseconds(1));
  expect_other("touched");
  fs::last_write_time(scratch / "x/deep/b", time);
  EXPECT_EQ(fingerprint(scratch / "x"), first);
  write_file_atomically(scratch / "x/deep/b", "more");
  fs::last_write_time(scratch / "x/deep/b", time);
  expect_other("longer");
  write_file_atomically(scratch / "x/deep/b", "two");
  fs::last_write_time(scratch / "x/deep/b", time);
  EXPECT_EQ(fingerprint(scratch / "x"), first);
  fs::rename(scratch / "x/deep/b", scratch / "x/deep/c");
  expect_other("renamed");
  fs::rename(scratch / "x/deep/c", scratch / "x/deep/b");
  fs::create_directory(scratch / "x/empty");
  expect_other("a folder more");
  fs::remove(scratch / "x/empty");
  fs::create_symlink("nowhere", scratch / "x/link");
  expect_other("a link more");
  fs::remove(scratch / "x/link");
  // What passes by itself is no change, nor is the name under which it is asked for.
  const OutputLock lock(scratch / "x/c");
  const Temporary temporary(scratch / "x/c");
  write_file_atomically(temporary.path(), "half");
  EXPECT_EQ(fingerprint(scratch / "x"), first);
  fs::create_directory_symlink("x", scratch / "y");
  EXPECT_EQ(fingerprint(scratch / "y"), first);
}

TEST(Fingerprint, OfAFile) {
  const Scratch scratch;
  write_file_atomically(scratch / "a", "one");
  const std::string first = fingerprint(scratch / "a");
  EXPECT_EQ(first.rfind("1 files, 3 bytes, ", 0), 0U) << first;
  fs::last_write_time(scratch / "a", fs::last_write_time(scratch / "a") + std::chrono::seconds(1));
  EXPECT_NE(fingerprint(scratch / "a"), first);
}

}  // namespace
}  // namespace simuli
