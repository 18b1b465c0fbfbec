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

/// Where a program came from: the compiler, the disk cache, or this Device's earlier programs.
enum class ProgramOrigin { kCompiled, kDisk, kMemory };

/// Kernel text built for one device, with those of the options that it names. A handle: copies refer to the
/// same program, and the same text with the same options is built once per Device. Error{kKernel} naming
/// file, options and build log when it doesn't build; Error{kDevice} for Precision::kDouble on a device
/// without fp64.
class Program {
 public:
  /// `path` is relative to cl/: "kernels/bin.cl".
  Program(const Device& device, std::string_view path, const BuildOptions& options = {});

  /// Builds text given directly; it may include the files of cl/. `name` stands for its path in logs.
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

/// A program as the device's compiler got it.
struct BuiltProgram {
  std::string path;  // "cl/kernels/bin.cl", or the name of a text
  std::string options;
};
/// What was built for the device so far, each once.
[[nodiscard]] std::vector<BuiltProgram> built_programs(const Device& device);

}  // namespace simuli
