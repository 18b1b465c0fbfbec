// Tests that Zarr stores are read as written, from folders and tar files, and that damage gives one-line
// errors.
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "io/base/file.hpp"
#include "io/zarr/itar_index.hpp"
#include "io/zarr/zarr_codec.hpp"
#include "io/zarr/zarr_store.hpp"
#include "io/zarr/zarr_writer.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::test {
namespace {

namespace fs = std::filesystem;

class ZarrTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!has_zarr()) GTEST_SKIP() << "not run: zarr arrays, built without libblosc or liblzma";
  }
};

std::vector<float> numbers(std::size_t count) {
  std::vector<float> out(count);
  std::iota(out.begin(), out.end(), 0.25F);
  return out;
}

/// Writes groups, an array in one chunk, one in rows, an empty one and a file.
void fill(ZarrWriter& writer) {
  const std::vector<float> values = numbers(12);
  writer.group("", Json{{"version", "v4"}});
  writer.group("a/b", Json{{"('rig', 'world')", 1.5}});
  writer.array("a/b/whole", {4, 3}, "<f4", std::span<const float>(values));
  writer.array("a/b/rows", {2, 6}, "<f4", std::span<const float>(values), Json{{"n", 2}}, {1, 6});
  writer.array("a/none", {0, 3}, "<f4", std::string());
  writer.file("a/picture", std::string("\x89PNG\0 not", 9), Json{{"format", "png"}});
  writer.group(std::string(90, 'x') + "/" + std::string(95, 'y'), Json{{"long", true}});
}

void check(const ZarrStore& store) {
  EXPECT_EQ(zarr_attributes(store, "").at("version"), "v4");
  EXPECT_EQ(zarr_attributes(store, "a/b").at("('rig', 'world')"), 1.5);
  EXPECT_EQ(zarr_attributes(store, "a"), Json::object());
  EXPECT_EQ(store.children("").size(), 2U);
  EXPECT_EQ(store.children("a"), (std::vector<std::string>{"b", "none", "picture"}));
  EXPECT_EQ(store.children("a/b"), (std::vector<std::string>{"rows", "whole"}));
  EXPECT_TRUE(is_group(store, "a/b"));
  EXPECT_FALSE(is_group(store, "a/picture"));
  const std::vector<float> values = numbers(12);
  const std::string bytes(reinterpret_cast<const char*>(values.data()), 48);
  for (const char* path : {"a/b/whole", "a/b/rows"})
    EXPECT_EQ(read_zarr_array(store, path).bytes, bytes) << path;
  EXPECT_EQ(read_zarr_array(store, "a/b/rows").shape, (std::vector<std::size_t>{2, 6}));
  EXPECT_TRUE(read_zarr_array(store, "a/none").bytes.empty());
  EXPECT_EQ(read_zarr_array(store, "a/picture").bytes, std::string("\x89PNG\0 not", 9));
}

TEST_P(ZarrTest, ReadsWhatWasWritten) {
  const Scratch scratch;
  const fs::path path = scratch / GetParam();
  write_zarr(path, fill);
  check(*open_zarr(path));
}

TEST_P(ZarrTest, HasTheSameBitsEachTime) {
  const Scratch scratch;
  const fs::path path = scratch / GetParam(), again = scratch / (std::string("again") + GetParam());
  write_zarr(path, fill);
  write_zarr(again, fill);
  const auto bytes = [](const fs::path& at) {
    return read_file(fs::is_directory(at) ? at / ".zmetadata.cbor.xz" : at);
  };
  EXPECT_EQ(bytes(path), bytes(again));
}

INSTANTIATE_TEST_SUITE_P(Containers, ZarrTest, ::testing::Values("a.zarr", "a.zarr.itar"));

TEST_F(ZarrTest, ReadsChunksOfAGridWithRemainders) {
  const Scratch scratch;
  // 3 x 5 items in chunks of 2 x 2, uncompressed, as written by others; items beyond the array are padding.
  fs::create_directories(scratch / "a.zarr/grid");
  std::ofstream(scratch / "a.zarr/.zgroup") << R"({"zarr_format": 2})";
  std::ofstream(scratch / "a.zarr/grid/.zarray")
      << R"({"zarr_format": 2, "shape": [3, 5], "chunks": [2, 2], "dtype": "|u1", "compressor": null,)"
      << R"( "filters": null, "order": "C", "fill_value": 0})";
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      std::string chunk;
      for (int k = 0; k < 4; ++k) chunk.push_back(static_cast<char>(10 * (2 * i + k / 2) + 2 * j + k % 2));
      std::ofstream(scratch / ("a.zarr/grid/" + std::to_string(i) + '.' + std::to_string(j))) << chunk;
    }
  }
  const ZarrArray grid = read_zarr_array(*open_zarr(scratch / "a.zarr"), "grid");
  ASSERT_EQ(grid.bytes.size(), 15U);
  for (int i = 0; i < 15; ++i) EXPECT_EQ(grid.bytes[static_cast<std::size_t>(i)], 10 * (i / 5) + i % 5) << i;
  fs::remove(scratch / "a.zarr/grid/1.1");
  expect_input_error([&] { (void)read_zarr_array(*open_zarr(scratch / "a.zarr"), "grid"); },
                     {"grid", "chunk 1.1", "none"});
}

/// Reads all arrays.
void read_all(const ZarrStore& store, const std::string& group) {
  (void)zarr_attributes(store, group);
  for (const std::string& child : store.children(group)) {
    const std::string path = zarr_key(group, child);
    if (is_array(store, path)) {
      (void)read_zarr_array(store, path);
    } else {
      read_all(store, path);
    }
  }
}

TEST_F(ZarrTest, NamesTheCompressorThatBloscIsWithout) {
  const Scratch scratch;
  write_zarr(scratch / "a.zarr", [](ZarrWriter& writer) {
    writer.array("many", {4096}, "<f4", std::span<const float>(numbers(4096)));
  });
  std::string chunk = read_file(scratch / "a.zarr/many/0");
  constexpr unsigned kFlags = 2,
                     kCompressor = 0xe0;  // bits of the header: all set, they name no known compressor
  chunk[kFlags] = static_cast<char>(static_cast<unsigned char>(chunk[kFlags]) | kCompressor);
  std::ofstream(scratch / "a.zarr/many/0") << chunk;
  expect_input_error([&] { (void)read_zarr_array(*open_zarr(scratch / "a.zarr"), "many"); },
                     {"many", "unknown compressor", "lz4"});
}

TEST_F(ZarrTest, RefusesEveryTruncationInOneLine) {
  const Scratch scratch;
  write_zarr(scratch / "a.itar", fill);
  const std::string whole = read_file(scratch / "a.itar");
  for (std::size_t size = 0; size < whole.size(); size += size % 512 == 511 ? 1 : 73) {
    const fs::path cut = scratch.file("cut.itar", whole.substr(0, size));
    expect_input_error([&] { (void)open_zarr(cut); }, {"cut.itar"});
  }
}

TEST_F(ZarrTest, RefusesAnIndexThatIsLargerThanWhatItLists) {
  const Scratch scratch;
  for (const std::size_t count : {std::size_t{20'000}, std::size_t{2'000'000}}) {
    const Json zeros(count, 0);
    const auto cbor = Json::to_cbor(
        Json{{"items", std::vector<std::string>(count)}, {"offset_datas", zeros}, {"sizes", zeros}});
    const std::string index = xz({cbor.begin(), cbor.end()});
    std::string file(kTarBlock, '\0');
    file += index;
    file.resize((file.size() + kTarBlock - 1) / kTarBlock * kTarBlock, '\0');
    file += itar_trailer({kTarBlock, index.size()});
    expect_input_error([&] { (void)open_zarr(scratch.file("bomb.itar", file)); },
                       {"bomb.itar: index: xz data", "more than 4608 bytes"});
  }
}

TEST_F(ZarrTest, RefusesFlippedBitsOfTheIndexAndOthersOrReadsThem) {
  const Scratch scratch;
  write_zarr(scratch / "a.itar", fill);
  const std::string whole = read_file(scratch / "a.itar");
  const std::size_t last = whole.size() - kTarBlock;
  const ItarTrailer index = read_itar_trailer(std::string_view(whole).substr(last), last, "a.itar");
  std::mt19937 random(7);
  for (int run = 0; run < 800; ++run) {
    std::string damaged = whole;
    const bool in_index = run % 2 == 0;
    const std::size_t at = in_index ? index.offset + random() % index.size : random() % whole.size();
    damaged[at] = static_cast<char>(damaged[at] ^ static_cast<char>(1U << random() % 8U));
    try {
      read_all(*open_zarr(scratch.file("a2.itar", damaged)), "");
      EXPECT_FALSE(in_index) << at;
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::kInput) << error.what();
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

TEST_F(ZarrTest, RefusesAnIndexThatLeadsElsewhere) {
  const std::string file = "x.itar";
  const auto cbor = [](const Json& json) {
    const auto bytes = Json::to_cbor(json);
    return std::string(bytes.begin(), bytes.end());
  };
  const auto read = [&](const Json& json) { return read_itar_index(cbor(json), 1000, file); };
  const Json good{{"items", {"a"}}, {"offset_datas", {512}}, {"sizes", {3}}};
  EXPECT_EQ(read(good).at("a").offset, 512U);
  for (const auto& [key, value] : std::vector<std::pair<std::string, Json>>{{"offset_datas", {1001}},
                                                                            {"sizes", {489}},
                                                                            {"sizes", Json::array()},
                                                                            {"items", {"a", "a"}},
                                                                            {"items", {3}},
                                                                            {"offset_datas", {-1}},
                                                                            {"other", {1}}}) {
    Json bad = good;
    bad[key] = value;
    expect_input_error([&] { (void)read(bad); }, {file, "index"});
  }
}

}  // namespace
}  // namespace simuli::test
