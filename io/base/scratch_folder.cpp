#include "io/base/scratch_folder.hpp"

#include <stdlib.h>
#include <system_error>

#include "io/base/temporary.hpp"

namespace simuli {

ScratchFolder::ScratchFolder(const std::string& name) {
  std::string pattern = (std::filesystem::temp_directory_path() / (name + "_XXXXXX")).string();
  if (::mkdtemp(pattern.data()) == nullptr) throw_errno(pattern, "folder", "one that can be made");
  path_ = pattern;
  remove_at_end(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a destructor must not throw; remains are in the temporary folder
  std::filesystem::remove_all(path_, ignored);
  keep_at_end(path_);
}

}  // namespace simuli
