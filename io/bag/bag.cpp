#include "io/bag/bag.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/regular_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// The parts of one recording, one after the other.
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

/// NAME_2 before NAME_10, as recorders number them.
bool is_before(const fs::path& a, const fs::path& b) {
  const std::string x = a.string(), y = b.string();
  return std::pair(x.size(), x) < std::pair(y.size(), y);
}

/// Messages that the recorder compressed one by one are no CDR, and only this file tells.
void need_plain_messages(const fs::path& metadata) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;
  if (!is_there(metadata)) return;
  const std::string text = read_file(metadata, kMost);
  for (const char* mode : {"compression_mode: message", "compression_mode: MESSAGE"}) {
    if (text.find(mode) != std::string::npos)
      throw_input_error(
          metadata.string(), "compression_mode", "message", "none or by file: ros2 bag convert");
  }
}

}  // namespace

std::unique_ptr<const Bag> open_bag(const fs::path& path) {
  const std::string ending = path.extension().string();
  std::error_code status;
  if (fs::is_directory(path, status)) {
    std::vector<fs::path> files;
    std::set<std::string> endings;
    bool has_packed = false;
    for (const auto& entry : fs::directory_iterator(path, status)) {
      const std::string of = entry.path().extension().string();
      has_packed = has_packed || of == ".zstd";
      if (of != ".mcap" && of != ".db3") continue;
      files.push_back(entry.path());
      endings.insert(of);
    }
    if (endings.size() != 1) {
      throw_input_error(path.string(),
                        "files",
                        !files.empty() ? "both .mcap and .db3"
                        : has_packed   ? "files that are compressed whole"
                                       : "no .mcap and no .db3",
                        has_packed ? "unpacked ones: unzstd *.zstd" : "one kind");
    }
    need_plain_messages(path / "metadata.yaml");
    std::sort(files.begin(), files.end(), is_before);
    return std::make_unique<const BagParts>(files);
  }
  if (!is_there(path)) throw_input_error(path.string(), "file", "none", "a recording");
  if (ending == ".mcap") return open_mcap(path);
  if (ending == ".db3") return open_sqlite_bag(path);
  throw_input_error(path.string(),
                    "ending",
                    '"' + ending + '"',
                    ".mcap, .db3, or a folder of such (unpack .zstd; ROS 1's .bag: rosbags-convert)");
}

}  // namespace simuli
