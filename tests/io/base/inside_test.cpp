#include <gtest/gtest.h>

#include "io/base/file.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

TEST(Inside, IsWhatLiesInTheFolder) {
  const Scratch scratch;
  fs::create_directories(scratch / "a.log/images");
  const fs::path folder = scratch / "a.log";
  EXPECT_EQ(inside(folder, "images/0.png", "log.json", "images[0].file"), folder / "images/0.png");
  EXPECT_EQ(inside(folder, "absent", "log.json", "points"), folder / "absent");
  for (const char* none : {"", "none", "none/", "./none/", "/none/"})
    EXPECT_EQ(inside(none, "absent", "log.json", "points"), fs::path(none) / "absent");
  // A link inside, and a folder that is a link.
  fs::create_symlink("images", folder / "pictures");
  EXPECT_EQ(inside(folder, "pictures/0.png", "log.json", "file"), folder / "pictures/0.png");
  fs::create_directory_symlink(folder, scratch / "linked.log");
  EXPECT_NO_THROW((void)inside(scratch / "linked.log", "images/0.png", "log.json", "file"));
}

TEST(Inside, RefusesWhatLeadsOut) {
  const Scratch scratch;
  const fs::path folder = scratch / "a.log";
  fs::create_directory(folder);
  const auto refused = [&](const char* path, const std::string& why) {
    expect_input_error([&] { (void)inside(folder, path, "log.json", "images[0].file"); },
                       {"log.json: images[0].file: found \"", why, "allowed a path inside"});
  };
  refused("", "\"\"");
  refused("/etc/passwd", "/etc/passwd");
  refused("../b.log/x", "../b.log/x");
  refused("images/../../x", "..");
  fs::create_directory(scratch / "a.log.other");
  fs::create_symlink("/etc/passwd", folder / "file");
  fs::create_directory_symlink("../a.log.other", folder / "folder");
  fs::create_symlink("circle", folder / "circle");
  refused("file", "a link that leads out");
  refused("folder/x", "a link that leads out");
  refused("circle", "which can't be followed");
  // Links to other disks are common in data sets.
  EXPECT_EQ(below(folder, "folder/x", "a.json", "filename"), folder / "folder/x");
  expect_input_error([&] { (void)below(folder, "../x", "a.json", "filename"); }, {"a.json: filename"});
}

}  // namespace
}  // namespace simuli
