#include "io/base/output.hpp"

#include <atomic>
#include <chrono>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "io/base/file.hpp"
#include "io/base/temporary.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace output_test {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

bool is_own(const std::string& name) { return name == "a" || name == "b"; }

std::size_t entries_of(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

void put(const fs::path& folder, const std::string& text) {
  replace_folder_atomically(
      folder, is_own, [&](const fs::path& beside) { write_file_atomically(beside / "a", text); });
}

TEST(ReplacedFolder, IsTheOldOneOrTheNewOne) {
  const Scratch scratch;
  put(scratch / "x", "old");
  EXPECT_EQ(read_file(scratch / "x/a"), "old");
  const auto fail_half_way = [&](const fs::path& beside) {
    write_file_atomically(beside / "a", "half");
    EXPECT_EQ(read_file(scratch / "x/a"), "old");
    throw std::runtime_error("disk full");
  };
  EXPECT_THROW(replace_folder_atomically(scratch / "x", is_own, fail_half_way), std::runtime_error);
  EXPECT_EQ(read_file(scratch / "x/a"), "old");
  put(scratch / "x/", "new");
  EXPECT_EQ(read_file(scratch / "x/a"), "new");
  EXPECT_EQ(entries_of(scratch.path()), 1U);
  // Through a link: its target is replaced.
  fs::create_directory_symlink("x", scratch / "link");
  put(scratch / "link", "newer");
  EXPECT_TRUE(fs::is_symlink(scratch / "link"));
  EXPECT_EQ(read_file(scratch / "x/a"), "newer");
}

TEST(ReplacedFolder, HasNothingOfOthers) {
  const Scratch scratch;
  fs::create_directory(scratch / "x");
  (void)scratch.file("x/notes.txt", "of somebody");
  expect_input_error([&] { put(scratch / "x", "new"); }, {"x: folder: found \"notes.txt\" in it"});
  expect_input_error([&] { need_replaceable(scratch / "x", is_own); }, {"notes.txt"});
  EXPECT_EQ(read_file(scratch / "x/notes.txt"), "of somebody");
  (void)scratch.file("y", "a file");
  expect_input_error([&] { put(scratch / "y", "new"); }, {"y: folder: found something else"});
  EXPECT_NO_THROW(need_replaceable(scratch / "none", is_own));
}

TEST(ReplacedFolder, ErrorsNameWhatWasAskedFor) {
  const Scratch scratch;
  expect_input_error(
      [&] {
        replace_folder_atomically(scratch / "x", is_own, [](const fs::path& beside) {
          throw_input_error((beside / "a").string(), "content", "a full disk", "room");
        });
      },
      {(scratch / "x/a").string() + ": content"});
}

TEST(OutputLock, IsOfOneProcess) {
  const Scratch scratch;
  const auto taken = [&] {
    const pid_t child = fork();
    if (child == 0) {
      try {
        const OutputLock lock(scratch / "x.scene");
      } catch (const Error& error) {
        const bool names_it =
            std::string(error.what()).find(std::to_string(::getppid())) != std::string::npos;
        ::_exit(names_it ? 1 : 2);
      }
      ::_exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WEXITSTATUS(status);
  };
  {
    const OutputLock lock(scratch / "x.scene");
    EXPECT_EQ(taken(), 1);
  }
  EXPECT_EQ(taken(), 0);
  EXPECT_EQ(entries_of(scratch.path()), 0U);
  // After a kill the file remains, the lock does not.
  const pid_t killed = fork();
  if (killed == 0) {
    const OutputLock lock(scratch / "x.scene");
    ::_exit(0);
  }
  waitpid(killed, nullptr, 0);
  EXPECT_EQ(entries_of(scratch.path()), 1U);
  EXPECT_EQ(taken(), 0);
  EXPECT_EQ(entries_of(scratch.path()), 0U);
}

TEST(NeedNewPath, IsOfNothingThatIsThere) {
  const Scratch scratch;
  EXPECT_NO_THROW(need_new_path(scratch / "new"));
  EXPECT_NO_THROW(need_new_path(scratch / "new/"));
  fs::create_directory(scratch / "folder");
  expect_input_error([&] { need_new_path(scratch / "folder/"); }, {"found something of that name"});
  fs::create_symlink("loop", scratch / "loop");
  expect_input_error([&] { need_new_path(scratch / "loop"); }, {"loop: folder", "does not exist yet"});
  expect_input_error([&] { need_new_path(scratch / "loop/x"); }, {"loop/x: folder: found Too many levels"});
  expect_input_error([&] { need_new_path(scratch / std::string(300, 'x')); }, {"File name too long"});
}

TEST(NeedWritable, SaysWhatWritingWould) {
  const Scratch scratch;
  EXPECT_NO_THROW(need_writable(scratch / "report.html"));
  EXPECT_EQ(entries_of(scratch.path()), 0U);
  expect_input_error([&] { need_writable(scratch / "no/report.html"); }, {"report.html: folder: found no"});
  fs::create_directory(scratch / "folder");
  expect_input_error([&] { need_writable(scratch / "folder"); }, {"found a folder"});
  expect_input_error([&] { need_writable("/proc/report.html"); }, {"/proc/report.html"});
}

TEST(Temporaries, AtTheEndAlsoThoseGoThatAreMadeJustThen) {
  const Scratch scratch;
  const pid_t ends = fork();
  if (ends == 0) {
    std::atomic<bool> has_begun = false;
    std::thread([&] {
      write_atomically(scratch / "x", [&](const fs::path& path) {
        has_begun = true;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        std::ofstream(path) << "half";
      });
    }).detach();
    while (!has_begun) std::this_thread::yield();
    remove_temporaries();
    ::_exit(0);
  }
  waitpid(ends, nullptr, 0);
  // Unless it was complete before the signal.
  EXPECT_EQ(entries_of(scratch.path()), fs::exists(scratch / "x") ? 1U : 0U);
}

TEST(Temporaries, GoSoonWhoeverHoldsThem) {
  const Scratch scratch;
  const pid_t ends = fork();
  if (ends == 0) {
    const Temporary folder(scratch / "x.log");  // of a thread in a long computation
    fs::create_directories(folder.path() / "images");
    const auto begin = std::chrono::steady_clock::now();
    remove_temporaries();
    ::_exit(std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(450) ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(ends, &status, 0), ends);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(entries_of(scratch.path()), 0U);
}

TEST(Temporaries, TakeProcessesThatWriteIntoThemAlong) {
  const Scratch scratch;
  const pid_t writer = fork();
  if (writer == 0) {
    ::setpgid(0, 0);
    for (;;) ::pause();
  }
  ::setpgid(writer, writer);
  const pid_t ends = fork();
  if (ends == 0) {
    kill_at_end(writer);
    remove_temporaries();
    ::_exit(0);
  }
  waitpid(ends, nullptr, 0);
  int status = 0;
  waitpid(writer, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

TEST(Temporaries, OfDeadProcessesGo) {
  const Scratch scratch;
  const pid_t dead = fork();
  if (dead == 0) ::_exit(0);
  waitpid(dead, nullptr, 0);
  const std::string name = ".x.scene." + std::to_string(dead) + "-6.tmp.checkpoint";
  (void)scratch.file(name, "half");
  (void)scratch.file(".x.scene." + std::to_string(::getppid()) + "-6.tmp.checkpoint", "of another's");
  (void)scratch.file(".x.scene.notes.checkpoint", "no temporary");
  fs::create_directory(scratch / (".x." + std::to_string(dead) + "-0.tmp.scene"));
  EXPECT_TRUE(is_temporary(name));
  EXPECT_FALSE(is_temporary(".x.scene.notes.checkpoint"));
  remove_stale_temporaries(scratch / "x.scene.checkpoint");
  EXPECT_EQ(entries_of(scratch.path()), 3U);
  write_folder_atomically(scratch / "x.scene", [](const fs::path&) {});
  EXPECT_EQ(entries_of(scratch.path()), 3U);  // the incomplete folder is removed, the complete one exists
  EXPECT_TRUE(fs::exists(scratch / "x.scene"));
}

/// Listing a folder needs a descriptor.
TEST(Temporaries, GoWithoutADescriptorLeft) {
  const Scratch scratch;
  const pid_t child = fork();
  if (child == 0) {
    {
      const Temporary folder(scratch / "x");
      fs::create_directories(folder.path() / "within");
      const Temporary file(folder.path() / "within/file");
      std::ofstream(file.path()) << "half";
      while (::open("/dev/null", O_RDONLY) >= 0) {
      }
    }
    // A temporary that could not be removed is not created.
    try {
      const Temporary another(scratch / "y");
      fs::create_directories(another.path());
    } catch (const Error&) {
    }
    ::_exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(entries_of(scratch.path()), 0U);
}

}  // namespace output_test
}  // namespace simuli
