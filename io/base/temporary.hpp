#pragma once
// Temporary files and folders beside their final path.
#include <filesystem>
#include <functional>
#include <string>
#include <sys/types.h>

namespace simuli {

/// A unique hidden name beside `target` with the same extension. Destruction removes it, unless it has become
/// the target.
class Temporary {
 public:
  explicit Temporary(const std::filesystem::path& target);
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Calls write(path()); errors that name the temporary path are rethrown with the target's name.
  void fill(const std::function<void(const std::filesystem::path&)>& write) const;
  /// Syncs the temporary, renames it to the target and syncs the folder; without syncing if the target is in
  /// another temporary folder. Throws Error{kInput} if it cannot be renamed.
  void become_target();
  /// become_target() for a target that is an existing folder: exchanges both in one step and removes the old
  /// one.
  void take_targets_place();

 private:
  void sync() const;

  std::filesystem::path target_, path_;
};

/// Removes all temporaries of this process, from a thread that is about to end it: writers must not continue
/// afterwards. Also removes the files of remove_at_end().
void remove_temporaries() noexcept;
/// Registers a path for remove_temporaries(), until keep_at_end().
void remove_at_end(const std::filesystem::path& path);
void keep_at_end(const std::filesystem::path& path);
/// Registers a process group that writes into a registered path: kill_groups() kills it, until spare_at_end().
void kill_at_end(pid_t group);
void spare_at_end(pid_t group);
/// Kills the registered groups, from a thread that is about to end the process; remove_temporaries() calls it
/// as well.
void kill_groups();

/// Removes temporaries of `target` whose processes ended without removing them.
void remove_stale_temporaries(const std::filesystem::path& target);
/// Whether the file has the name of a temporary.
[[nodiscard]] bool is_temporary(const std::filesystem::path& file);

/// Returns the folder that contains `path`; "." for a bare name.
[[nodiscard]] std::filesystem::path parent_of(const std::filesystem::path& path);
/// "x/" names the same folder as "x", but has no file name.
[[nodiscard]] std::filesystem::path without_trailing_slash(const std::filesystem::path& path);
/// Throws Error{kInput} with the message of errno.
[[noreturn]] void throw_errno(const std::filesystem::path& file, const char* field, const char* allowed);

/// Owner of a POSIX descriptor; writers call close() to detect late write errors.
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
