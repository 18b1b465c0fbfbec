#pragma once
// Files and folders on their way to be there: written beside what they become, under a name of their own.
#include <filesystem>
#include <functional>
#include <sys/types.h>

namespace simuli {

/// A name beside `target` that no other process or thread uses, hidden and with the same extension. What
/// stands there at the end is removed, unless it has become the target.
class Temporary {
 public:
  explicit Temporary(const std::filesystem::path& target);
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Calls write(path()); errors that name it name the target instead: the other is gone when they are read.
  void fill(const std::function<void(const std::filesystem::path&)>& write) const;
  /// Flushes it to the disk, renames it to the target and makes that last; without either where the target is
  /// in another temporary one. Error{kInput} when it can't be renamed.
  void become_target();
  /// The same where the target is a folder that is there: the two change places in one step, and the old one
  /// is removed.
  void take_targets_place();

 private:
  void sync() const;

  std::filesystem::path target_, path_;
};

/// Removes what all of this process's temporaries stand for, from a thread that is about to end it: whoever
/// writes them must not go on afterwards. Further files to be removed then are named by remove_at_end().
void remove_temporaries() noexcept;
/// Also removed by remove_temporaries(), until keep_at_end().
void remove_at_end(const std::filesystem::path& path);
void keep_at_end(const std::filesystem::path& path);
/// A group of processes that write into what is removed: killed by kill_groups(), before or after this, until
/// spare_at_end().
void kill_at_end(pid_t group);
void spare_at_end(pid_t group);
/// From a thread that is about to end the process, now or soon; remove_temporaries() does so, too.
void kill_groups();

/// Removes temporaries of `target` whose processes are dead: killed before they could.
void remove_stale_temporaries(const std::filesystem::path& target);
/// Whether a file of that name is somebody's temporary.
[[nodiscard]] bool is_temporary(const std::filesystem::path& file);

/// The folder that `path` is in; "." for a bare name.
[[nodiscard]] std::filesystem::path parent_of(const std::filesystem::path& path);
/// "x/" names the same folder as "x", but has no file name of its own.
[[nodiscard]] std::filesystem::path without_trailing_slash(const std::filesystem::path& path);
/// Throws Error{kInput} with what errno says.
[[noreturn]] void throw_errno(const std::filesystem::path& file, const char* field, const char* allowed);

/// Owner of a POSIX descriptor; close() is for writers, which must learn of a late write error.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] int close();
  [[nodiscard]] int release();

 private:
  int descriptor_;
};

}  // namespace simuli
