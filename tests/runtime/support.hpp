#pragma once
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <string_view>

#include "host/core/base/error.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::test {

/// Sets an environment variable (nothing: unsets it) until the end of the scope.
class ScopedEnvironment {
 public:
  ScopedEnvironment(std::string name, const std::optional<std::string>& value);
  ~ScopedEnvironment();
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

 private:
  std::string name_;
  std::optional<std::string> before_;
};

/// A folder of its own, removed at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A new handle on the default device. No device is a failure: the Error ends the test.
[[nodiscard]] Device open_device(bool profiling = false);

void write_text(const std::filesystem::path& file, std::string_view text);
[[nodiscard]] std::string read_text(const std::filesystem::path& file);

/// Runs f, which has to throw an Error of that kind; returns its message.
[[nodiscard]] std::string error_of(ErrorKind kind, const std::function<void()>& f);

/// Whether `text` contains every one of `parts`; the failure shows both.
[[nodiscard]] testing::AssertionResult contains(const std::string& text,
                                                std::initializer_list<std::string_view> parts);

}  // namespace simuli::test
