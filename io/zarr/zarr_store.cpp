#include "io/zarr/zarr_store.hpp"

#include <algorithm>
#include <set>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGroup = ".zgroup";
constexpr const char* kArray = ".zarray";

class FolderStore : public ZarrStore {
 public:
  explicit FolderStore(fs::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] bool has(const std::string& key) const override {
    std::error_code ignored;
    return fs::is_regular_file(folder_ / key, ignored);
  }
  [[nodiscard]] std::string read(const std::string& key) const override {
    return read_file(folder_ / key, kLargestEntry);
  }
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const override {
    std::vector<std::string> out;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder_ / group, failed)) {
      const std::string child = entry.path().filename().string();
      const std::string path = zarr_key(group, child);
      if (is_group(*this, path) || is_array(*this, path)) out.push_back(child);
    }
    std::sort(out.begin(), out.end());
    return out;
  }
  [[nodiscard]] std::string name() const override { return folder_.string(); }

 private:
  fs::path folder_;
};

}  // namespace

std::string zarr_key(const std::string& group, const std::string& name) {
  return group.empty() ? name : group + '/' + name;
}

bool is_group(const ZarrStore& store, const std::string& path) { return store.has(zarr_key(path, kGroup)); }
bool is_array(const ZarrStore& store, const std::string& path) { return store.has(zarr_key(path, kArray)); }

Json zarr_attributes(const ZarrStore& store, const std::string& path) {
  const std::string key = zarr_key(path, ".zattrs");
  if (!store.has(key)) return Json::object();
  const std::string file = store.name() + ": " + key;
  Json out = parse_json(store.read(key), file);
  if (!out.is_object()) throw_input_error(file, "root", "no object", "an object {...}");
  return out;
}

std::unique_ptr<const ZarrStore> open_zarr(const fs::path& path) {
  std::error_code ignored;
  if (!is_there(path)) throw_input_error(path.string(), "file", "none", "a Zarr folder or an .itar");
  if (!has_zarr()) {
    throw_input_error(path.string(),
                      "kind",
                      "a Zarr store, which this build can't read",
                      "a build with libblosc and liblzma");
  }
  if (!fs::is_directory(path, ignored)) return open_itar(path);
  auto store = std::make_unique<const FolderStore>(path);
  if (is_group(*store, "")) return store;
  throw_input_error(path.string(), kGroup, "none", "the folder of a Zarr v2 store");
}

}  // namespace simuli
