#pragma once
// Checks and locks of the output of a long computation, made before it begins.
#include <filesystem>
#include <functional>
#include <string>

#include "host/core/base/error.hpp"

namespace simuli {

/// Returns the lock file that exists while a process creates `output`, or after such a process was killed.
[[nodiscard]] std::filesystem::path lock_beside(const std::filesystem::path& output);

/// Another process holds the OutputLock.
class OutputTaken : public Error {
 public:
  using Error::Error;
};

/// Makes this process the only one that creates `output`, until destruction or the end of the process: a file
/// lock on ".NAME.lock" beside it, which is removed at the end. Creates missing parent folders. Throws
/// OutputTaken{kInput} with the process id if another process holds it; Error{kInput} if nothing can be
/// written.
class OutputLock {
 public:
  explicit OutputLock(const std::filesystem::path& output);
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  ~OutputLock();

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// Throws the Error{kInput} that write_atomically() would throw at the end. Refuses to replace files of logs
/// and scenes, but not pages beside them.
void need_writable(const std::filesystem::path& file);

/// Throws Error{kInput} if something has that name, including dangling links, or nothing can be created there.
void need_new_path(const std::filesystem::path& output);

/// write_folder_atomically() that replaces an existing folder in one step if all its files satisfy `is_own(file
/// name)`. Throws Error{kInput} for other folders, so that foreign files are never removed.
void replace_folder_atomically(const std::filesystem::path& folder,
                               const std::function<bool(const std::string&)>& is_own,
                               const std::function<void(const std::filesystem::path&)>& write);
/// Throws the errors of replace_folder_atomically() that can be detected in advance.
void need_replaceable(const std::filesystem::path& folder,
                      const std::function<bool(const std::string&)>& is_own);

}  // namespace simuli
