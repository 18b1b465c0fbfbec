#pragma once
// Drawing on a picture: what diagrams need, no more.
#include <array>
#include <string_view>

#include "io/picture/image.hpp"

namespace simuli::cli {

using Colour = std::array<float, 3>;  // in [0, 1]

class Canvas {
 public:
  Canvas(int width, int height, const Colour& background);

  /// Pixels [x0, x1) x [y0, y1), as much of them as there is.
  void fill(int x0, int y0, int x1, int y1, const Colour& colour);
  /// Capital letters, digits and a little punctuation, 12 x 14 px a character from its top left corner;
  /// others are blanks.
  void text(int x, int y, std::string_view text, const Colour& colour);
  static constexpr int kCharacterWidth = 12;
  static constexpr int kCharacterHeight = 14;

  [[nodiscard]] const Image& image() const { return image_; }

 private:
  Image image_;
};

}  // namespace simuli::cli
