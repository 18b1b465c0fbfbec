#include "host/cli/view/uploaded.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdlib.h>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/names.hpp"
#include "io/base/file.hpp"
#include "io/scene/splat_scene.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

/// Removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "simuli-view-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) {
      throw_input_error(pattern, "folder", std::strerror(errno), "one that can be made");
    }
    path_ = pattern;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

Scene uploaded_scene(const std::string& name, const std::string& bytes) {
  const std::string shown = name_from(name);
  if (!is_splat_file(shown)) throw_input_error(shown, "extension", "another one", ".ply or .spz");
  const TemporaryFolder folder;
  try {
    write_file_atomically(folder.path() / shown, bytes);
    return scene_of_splats(folder.path() / shown).scene;
  } catch (const Error& error) {
    std::string text = error.what();
    const std::string prefix = folder.path().string() + '/';
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) {
      text.erase(at, prefix.size());
    }
    throw Error(error.kind(), text);
  }
}

}  // namespace simuli::cli
