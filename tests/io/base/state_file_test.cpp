#include "io/base/state_file.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using Bytes = std::vector<std::byte>;

Bytes some_bytes(std::size_t count, int seed) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i)
    bytes[i] = static_cast<std::byte>((i * 37 + static_cast<std::size_t>(seed)) & 255U);
  return bytes;
}

class StateFileTest : public testing::Test {
 protected:
  std::filesystem::path write() const {
    const std::filesystem::path file = scratch_ / "training.checkpoint";
    write_state_file(file, [](StateWriter& writer) {
      writer.add("camera/parameters", some_bytes(1001, 1));
      writer.add("nothing", {});
      writer.add("iteration", some_bytes(8, 2));
    });
    return file;
  }
  test::Scratch scratch_;

  static void expect_refused(const std::filesystem::path& file, const std::string& part) {
    try {
      const StateFile state(file);
      for (const std::string& name : state.names()) (void)state.block(name);
      ADD_FAILURE() << "accepted: " << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
};

TEST_F(StateFileTest, BlocksComeBackAsTheyWere) {
  const StateFile file(write());
  EXPECT_EQ(file.names(), (std::vector<std::string>{"camera/parameters", "iteration", "nothing"}));
  EXPECT_EQ(file.block("camera/parameters"), some_bytes(1001, 1));
  EXPECT_EQ(file.block("iteration"), some_bytes(8, 2));
  EXPECT_TRUE(file.block("nothing").empty());
  EXPECT_FALSE(file.has("lidar/parameters"));
  EXPECT_THROW((void)file.block("lidar/parameters"), Error);
  // No other file exists beside it.
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch_.path()))
    files += entry.is_regular_file() ? 1U : 0U;
  EXPECT_EQ(files, 1U);
}

TEST_F(StateFileTest, AnyCutAndAnyChangedByteIsRefused) {
  const std::filesystem::path file = write();
  const auto size = std::filesystem::file_size(file);
  for (const std::uintmax_t shorter : {size - 1,
                                       size - 8,
                                       size / 2,
                                       std::uintmax_t{40},
                                       std::uintmax_t{17},
                                       std::uintmax_t{3},
                                       std::uintmax_t{0}}) {
    std::filesystem::resize_file(write(), shorter);
    expect_refused(file, "training.checkpoint");
  }
  for (std::uintmax_t at = 0; at < size; at += 13) {
    write();
    {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekg(static_cast<std::streamoff>(at));
      const int byte = stream.get();
      stream.seekp(static_cast<std::streamoff>(at));
      stream.put(static_cast<char>(byte ^ 0x10));
    }
    // A changed name is a missing block for the reader; all other damage is detected.
    try {
      const StateFile state(file);
      const bool same = state.has("camera/parameters") && state.has("nothing") && state.has("iteration") &&
                        state.block("camera/parameters") == some_bytes(1001, 1) &&
                        state.block("iteration") == some_bytes(8, 2) && state.block("nothing").empty();
      EXPECT_FALSE(same) << at;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
    }
  }
  expect_refused(scratch_ / "none", "none");
  std::ofstream(scratch_ / "text") << "this is no state of a training at all";
  expect_refused(scratch_ / "text", "first bytes");
}

TEST_F(StateFileTest, AFailedWriteLeavesTheOldFile) {
  const std::filesystem::path file = write();
  EXPECT_THROW(write_state_file(file,
                                [](StateWriter& writer) {
                                  writer.add("half", some_bytes(10, 3));
                                  throw Error(ErrorKind::kInternal, "stopped");
                                }),
               Error);
  EXPECT_EQ(StateFile(file).block("iteration"), some_bytes(8, 2));
}

}  // namespace
}  // namespace simuli
