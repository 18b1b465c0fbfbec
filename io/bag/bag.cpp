#include "io/bag/bag.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// The parts of a split recording, in order.
class BagParts : public Bag {
 public:
  explicit BagParts(const std::vector<fs::path>& files) {
    for (const fs::path& file : files) parts_.push_back(open_bag(file));
  }
  void read(const Wanted& wanted, const OnMessage& on_message) const override {
    for (const auto& part : parts_) part->read(wanted, on_message);
  }

 private:
  std::vector<std::unique_ptr<const Bag>> parts_;
};

/// Sorts NAME_2 before NAME_10, as recorders number their parts.
bool is_before(const fs::path& a, const fs::path& b) {
  const std::string x = a.string(), y = b.string();
  return std::pair(x.size(), x) < std::pair(y.size(), y);
}

/// A file type that is not a ROS 2 recording, and its signature.
struct Other {
  std::string_view first_bytes;
  const char *found, *tool;
};

/// Detects the type by the first bytes, independent of the name; null for a possible recording.
const Other* other_kind(const fs::path& file) {
  using namespace std::string_view_literals;
  constexpr const char* kPacked = "one that is compressed whole";
  static constexpr std::array<Other, 8> kKinds{
      {{"\x1f\x8b"sv, kPacked, "gunzip"},
       {"\x28\xb5\x2f\xfd"sv, kPacked, "unzstd"},
       {"\x04\x22\x4d\x18"sv, kPacked, "unlz4"},
       {"BZh"sv, kPacked, "bunzip2"},
       {"\3757zXZ"sv, kPacked, "unxz"},
       {"PK\3\4"sv, "a zip archive", "unzip"},
       {"#ROSBAG V"sv, "a bag of ROS 1", "rosbags-convert"},
       {"version https://git-lfs"sv, "a pointer of Git LFS instead of the content", "git lfs pull"}}};
  std::string first(24, '\0');
  std::error_code status;
  if (fs::is_regular_file(file, status)) std::ifstream(file, std::ios::binary).read(first.data(), 24);
  const auto* const kind = std::find_if(
      kKinds.begin(), kKinds.end(), [&](const Other& other) { return first.starts_with(other.first_bytes); });
  return kind == kKinds.end() ? nullptr : kind;
}

/// Returns the name in an entry of a YAML list, without blanks and quotes around it: `"a_0.mcap"` is a_0.mcap.
std::string name_of(std::string_view entry) {
  constexpr std::string_view kAround = "\"' \t\r";
  const std::size_t first = entry.find_first_not_of(kAround);
  if (first == std::string_view::npos) return {};
  return std::string(entry.substr(first, entry.find_last_not_of(kAround) + 1 - first));
}

/// metadata.yaml is the only file that lists parts, which may be missing, and per-message compression, which is
/// not supported. It keeps the original names when parts are renamed.
void need_whole(const fs::path& metadata, std::size_t parts) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;
  if (!is_there(metadata)) return;
  const std::string text = read_file(metadata, kMost);
  for (const char* mode : {"compression_mode: message", "compression_mode: MESSAGE"}) {
    if (text.find(mode) != std::string::npos)
      throw_input_error(
          metadata.string(), "compression_mode", "message", "none or by file: ros2 bag convert");
  }
  const std::size_t from = text.find("relative_file_paths:");
  if (from == std::string::npos) return;
  std::istringstream lines(text.substr(from));
  std::string line, missing;
  std::getline(lines, line);
  std::size_t named = 0;
  for (; lines >> line && line == "-" && std::getline(lines >> std::ws, line); ++named) {
    const std::string part = name_of(line);
    if (part.empty())
      throw_input_error(metadata.string(), "relative_file_paths", "an empty name", "names of files");
    if (!is_there(metadata.parent_path() / fs::path(part).filename()))
      missing += (missing.empty() ? "" : ", ") + part;
  }
  if (parts < named) {
    throw_input_error(metadata.string(),
                      "relative_file_paths",
                      fmt::format("{} of which {} files are there, without {}", named, parts, missing),
                      "all of them, or no metadata.yaml: what is there");
  }
}

}  // namespace

std::unique_ptr<const Bag> open_bag(const fs::path& path) {
  const std::string ending = ending_of(path);
  std::error_code status;
  if (fs::is_directory(path, status)) {
    std::vector<fs::path> files;
    std::set<std::string> endings;
    const Other* other = nullptr;
    for (const auto& entry : fs::directory_iterator(path, status)) {
      const std::string of = ending_of(entry.path());
      if (of != ".mcap" && of != ".db3") {
        if (other == nullptr) other = other_kind(entry.path());
        continue;
      }
      files.push_back(entry.path());
      endings.insert(of);
    }
    if (endings.size() != 1) {
      throw_input_error(path.string(),
                        "files",
                        !files.empty()     ? "both .mcap and .db3"
                        : other != nullptr ? other->found
                                           : "no .mcap and no .db3",
                        other != nullptr ? fmt::format("recordings of ROS 2: {}", other->tool) : "one kind");
    }
    need_whole(path / "metadata.yaml", files.size());
    std::sort(files.begin(), files.end(), is_before);
    return std::make_unique<const BagParts>(files);
  }
  if (!is_there(path)) throw_input_error(path.string(), "file", "none", "a recording");
  if (const Other* other = other_kind(path))
    throw_input_error(
        path.string(), "file", other->found, fmt::format("a recording of ROS 2: {}", other->tool));
  if (ending == ".mcap") return open_mcap(path);
  if (ending == ".db3") return open_sqlite_bag(path);
  throw_input_error(path.string(),
                    "ending",
                    '"' + ending + '"',
                    ".mcap, .db3, or a folder of such (ROS 1's .bag: rosbags-convert)");
}

}  // namespace simuli
