#pragma once
// Where a long work's result will be put, looked after before the work begins.
#include <filesystem>
#include <functional>
#include <string>

#include "host/core/base/error.hpp"

namespace simuli {

/// What is there while a process makes `output`, and after one that was killed.
[[nodiscard]] std::filesystem::path lock_beside(const std::filesystem::path& output);

/// Somebody else has the OutputLock.
class OutputTaken : public Error {
 public:
  using Error::Error;
};

/// Whoever has it is the only process that makes `output`, until it is destroyed or dies, however it dies: a
/// file lock on ".NAME.lock" beside it, which is removed again. Missing folders above are made.
/// OutputTaken{kInput} when another process has it, with its number; Error{kInput} where nothing can be
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

/// Error{kInput} when write_atomically() could not write a file of that name: what it would say at the end. Files of
/// logs and scenes are not replaced, pages beside them are.
void need_writable(const std::filesystem::path& file);

/// Error{kInput} when there is something of that name, links that lead nowhere too, or there can't be.
void need_new_path(const std::filesystem::path& output);

/// As write_folder_atomically(); but an older folder of that name is replaced, in one step, when all that is
/// in it is its own by `is_own(file name)`. Error{kInput} for others: nobody's files are removed.
void replace_folder_atomically(const std::filesystem::path& folder,
                               const std::function<bool(const std::string&)>& is_own,
                               const std::function<void(const std::filesystem::path&)>& write);
/// The part of it that can be known before: Error{kInput} when there is something else of that name.
void need_replaceable(const std::filesystem::path& folder,
                      const std::function<bool(const std::string&)>& is_own);

}  // namespace simuli
