#pragma once
#include <filesystem>
#include <string>

namespace simuli {

/// A new folder NAME_... below the temporary one, removed with all that is in it, also when the process is
/// told to end (temporary.hpp). Error{kInput} when it can't be made.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace simuli
