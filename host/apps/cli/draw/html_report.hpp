#pragma once
// A report as one HTML file that needs nothing beside it: tables, curves, pictures, pictures to compare,
// point clouds to turn. For wide and narrow windows, and for paper.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/draw/chart.hpp"
#include "io/picture/image.hpp"

namespace simuli {

/// How a picture is kept: as it is, or as JPEG of kPhotoQuality, a fifth of the size.
enum class PictureCode { kLossless, kPhoto };
inline constexpr int kPhotoQuality = 92;

/// Points of one colour, of which a report keeps kMostPoints, evenly spread, to 16 bits of the largest
/// coordinate.
struct CloudLayer {
  static constexpr std::size_t kMostPoints = 40'000;

  std::string name;
  std::string colour;                 // "#rrggbb"
  bool is_shown = true;               // at first
  std::vector<float> xyz = {};        // [N, 3] m, x forward, y left, z up, of the middle of the view
  std::vector<float> intensity = {};  // [N], 0 to 1
};
/// Corners in the same frame, of which k and k ^ 1, k ^ 2, k ^ 4 have an edge.
using CloudBox = std::array<std::array<float, 3>, 8>;

class HtmlReport {
 public:
  /// All text of a report is plain and is escaped.
  HtmlReport(std::string title, std::string subtitle);

  /// Begins a part, which the list below the title leads to.
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// What matters most, large, each with its name below; `text` stands above.
  struct Fact {
    std::string name;
    std::string value;
  };
  void facts(const std::string& text, const std::vector<Fact>& facts);
  /// The first column is a row's name. On a phone each row of a wide table is a block of its own, with the
  /// columns' names in it. Every row has as many cells as `header`.
  void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  /// The same of words.
  void text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  /// A table of words, folded away behind `summary`; on paper it is left out.
  void folded_table(const std::string& summary,
                    const std::vector<std::string>& header,
                    const std::vector<std::vector<std::string>>& rows);
  /// Curves over one axis, drawn as vectors. Nothing is shown when no series has two finite points.
  void chart(const std::string& title, const std::string& x_label, const std::vector<ChartSeries>& series);
  /// A group of bars per label, a bar of each series. Nothing is shown when nothing is finite.
  void bars(const std::string& title,
            const std::vector<std::string>& labels,
            const std::vector<ChartSeries>& series);
  /// `caption` stands below. A click shows it large.
  void picture(const Image& image, const std::string& caption, PictureCode code = PictureCode::kLossless);
  /// Two pictures of one size over each other, parted by a line that the reader drags.
  void compare(const Image& left,
               const std::string& left_label,
               const Image& right,
               const std::string& right_label,
               const std::string& caption,
               PictureCode code = PictureCode::kLossless);
  /// Points that the reader turns. Layers without points are left out; nothing is shown without any.
  void cloud(const std::vector<CloudLayer>& layers,
             const std::vector<CloudBox>& boxes,
             const std::string& caption);

  /// The whole page.
  [[nodiscard]] std::string html() const;
  /// Atomic. Error{kInput} when the file can't be written.
  void write(const std::filesystem::path& file) const;

 private:
  /// Figures of a kind that follow each other stand beside each other; "": what stands alone.
  void add(const std::string& group, const std::string& html);
  void add_figure(const Image& size, const std::string& shot, const std::string& caption);
  [[nodiscard]] std::string table_html(const char* css_class,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::vector<std::string>>& rows) const;

  std::string title_, subtitle_, body_;
  std::string group_;  // that is open in body_
  std::vector<std::string> headings_;
};

}  // namespace simuli
