#pragma once
#include <string>

namespace simuli::test {

/// Returns a particle of SH degree 0 as ASCII PLY, with additional header lines and other values if given.
inline std::string ascii_ply(const std::string& extra_header = "",
                             const std::string& values = "1 2 3 4 5 6 7 8 9 10 1 0 0 0\n") {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 1\n";
  for (const char* name : {"x",
                           "y",
                           "z",
                           "f_dc_0",
                           "f_dc_1",
                           "f_dc_2",
                           "opacity",
                           "scale_0",
                           "scale_1",
                           "scale_2",
                           "rot_0",
                           "rot_1",
                           "rot_2",
                           "rot_3"}) {
    text += std::string("property float ") + name + "\n";
  }
  return text + extra_header + "end_header\n" + values;
}

/// Returns two particles, one of which is invalid.
inline std::string half_broken_ply() {
  std::string text = ascii_ply("", "1 2 3 4 5 6 7 8 9 10 1 0 0 0\n1 2 nan 4 5 6 7 8 9 10 1 0 0 0\n");
  return text.replace(text.find("vertex 1"), 8, "vertex 2");
}

}  // namespace simuli::test
