#pragma once
#include <span>
#include <string>
#include <string_view>

namespace simuli {

/// One file of cl/ as embedded at build time; the path is relative to cl/ ("kernels/bin.cl").
struct EmbeddedFile {
  std::string_view path;
  std::string_view text;
};

/// All embedded files, in the order of cl/files.cmake.
[[nodiscard]] std::span<const EmbeddedFile> embedded_files();

/// Text of the file `path` relative to cl/: from the folder $SIMULI_CL_DIR when that is set (all files
/// come from there then), else as embedded. Error{kKernel} naming the file when it is missing.
[[nodiscard]] std::string load_source(std::string_view path);

/// The file with its quoted includes spliced in, each once (so includes are unconditional and need no
/// guards), and #line directives so that build logs name "cl/math/lidar.h:3". Includes are looked for
/// beside the including file, then in cl/, then beside cl/ ("cl/math/lidar.h", as C++ writes it).
/// Angle-bracket includes are left alone: shared headers have them for C++.
[[nodiscard]] std::string expand_file(std::string_view path);

/// The same for text given directly; `name` stands for its path in logs.
[[nodiscard]] std::string expand_text(std::string_view name, std::string_view text);

}  // namespace simuli
