#pragma once
#include <filesystem>
#include <string>

namespace simuli {

/// A new folder NAME_... in the system's temporary folder, removed with its contents, also when the process is
/// terminated (temporary.hpp). Throws Error{kInput} if it cannot be created.
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
