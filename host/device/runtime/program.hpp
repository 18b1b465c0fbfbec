#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

namespace detail {
struct ProgramState;
}

/// Origin of a program: the compiler, the disk cache, or an earlier program of this Device.
enum class ProgramOrigin { kCompiled, kDisk, kMemory };

/// A kernel text built for one device with the options that the text uses. A handle: copies refer to the same
/// program, and each Device builds the same text and options once. Throws Error{kKernel} with file, options and
/// build log when the build fails, and Error{kDevice} for Precision::kDouble on a device without fp64.
class Program {
 public:
  /// `path` is relative to cl/: "kernels/bin.cl".
  Program(const Device& device, std::string_view path, const BuildOptions& options = {});

  /// Builds the given text, which may include files of cl/. Logs show `name` as its path.
  [[nodiscard]] static Program from_text(const Device& device,
                                         std::string_view name,
                                         std::string_view text,
                                         const BuildOptions& options = {});

  [[nodiscard]] const Device& device() const { return device_; }
  [[nodiscard]] ProgramOrigin origin() const { return origin_; }
  [[nodiscard]] Precision precision() const;
  [[nodiscard]] const std::string& path() const;
  [[nodiscard]] std::vector<std::string> kernel_names() const;
  [[nodiscard]] const detail::ProgramState& state() const { return *state_; }

 private:
  struct Expanded {
    std::string shown;
    std::string source;
  };
  Program(const Device& device, const Expanded& expanded, const BuildOptions& options);

  Device device_;
  std::shared_ptr<const detail::ProgramState> state_;
  ProgramOrigin origin_ = ProgramOrigin::kCompiled;
};

/// The inputs of one program build.
struct BuiltProgram {
  std::string path;  // "cl/kernels/bin.cl", or the name of a given text
  std::string options;
};
/// Returns all programs built for the device so far, each once.
[[nodiscard]] std::vector<BuiltProgram> built_programs(const Device& device);

}  // namespace simuli
