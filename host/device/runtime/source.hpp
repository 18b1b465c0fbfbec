#pragma once
#include <span>
#include <string>
#include <string_view>

namespace simuli {

/// A file of cl/ embedded at build time; its path is relative to cl/ ("kernels/bin.cl").
struct EmbeddedFile {
  std::string_view path;
  std::string_view text;
};

/// Returns all embedded files in the order of cl/files.cmake.
[[nodiscard]] std::span<const EmbeddedFile> embedded_files();

/// Returns the text of the file `path` relative to cl/: from the folder $SIMULI_CL_DIR if that is set (then for
/// all files), else the embedded text. Throws Error{kKernel} with the file name when it is missing.
[[nodiscard]] std::string load_source(std::string_view path);

/// Returns the file with its quoted includes inserted, each once (so includes are unconditional and need no
/// guards), and #line directives so that build logs name "cl/math/lidar.h:3". Includes are searched in the folder
/// of the including file, then in cl/, then in the parent of cl/ ("cl/math/lidar.h", as in C++). Includes in angle
/// brackets are kept: shared headers have them for C++.
[[nodiscard]] std::string expand_file(std::string_view path);

/// Expands the given text in the same way; logs show `name` as its path.
[[nodiscard]] std::string expand_text(std::string_view name, std::string_view text);

}  // namespace simuli
