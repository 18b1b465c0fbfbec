#include "host/cli/draw/html_report.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "io/base/file.hpp"
#include "io/picture/image.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Image ramp(int width, int height) {
  Image image(width, height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>(i % 256) / 255.0F;
  }
  return image;
}

TEST(HtmlReport, EscapesWhatItIsGiven) {
  HtmlReport report("<b> & \"c\"", "sub");
  report.paragraph("<script>alert(1)</script>");
  report.table({"a", "b"}, {{"<i>", "1"}});
  const std::string html = report.html();
  EXPECT_TRUE(holds(html, "<title>&lt;b&gt; &amp; &quot;c&quot;</title>"));
  EXPECT_FALSE(holds(html, "alert(1)</script>"));
  EXPECT_TRUE(holds(html, "<td>&lt;i&gt;</td><td>1</td>"));
}

TEST(HtmlReport, NeedsNothingBesideItself) {
  HtmlReport report("title", "sub");
  report.picture(ramp(4, 3), "a");
  report.compare(ramp(4, 3), "left", ramp(4, 3), "right", "b");
  report.chart("c", "x", {{"s", {0.0, 1.0}, {2.0, 3.0}}});
  const std::string html = report.html();
  EXPECT_FALSE(holds(html, "http:"));
  EXPECT_FALSE(holds(html, "https:"));
  for (std::size_t at = html.find("src="); at != std::string::npos; at = html.find("src=", at + 1)) {
    EXPECT_EQ(html.compare(at, 27, "src=\"data:image/png;base64,"), 0);
  }
}

TEST(HtmlReport, LeavesOutWhatCantBeDrawn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  HtmlReport report("title", "sub");
  report.chart("empty", "x", {{"s", {}, {}}});
  report.chart("nowhere", "x", {{"s", {0.0, 1.0}, {nan, nan}}});
  EXPECT_FALSE(holds(report.html(), "<svg"));
  report.chart("flat", "x", {{"s", {0.0, 1.0, 2.0}, {5.0, nan, 5.0}}});
  EXPECT_TRUE(holds(report.html(), "<polyline"));
  EXPECT_FALSE(holds(report.html(), "nan"));
}

TEST(HtmlReport, WritesTheWholePage) {
  const test::Scratch scratch;
  HtmlReport report("title", "sub");
  report.heading("part");
  report.write(scratch / "r.html");
  EXPECT_EQ(read_file(scratch / "r.html"), report.html());
}

TEST(EncodeImage, IsWhatTheReaderReads) {
  const test::Scratch scratch;
  const Image image = ramp(16, 9);
  write_file_atomically(scratch / "a.png", encode_image(image, ImageCode::kPng));
  const Image png = read_image(scratch / "a.png");
  ASSERT_EQ(png.data.size(), image.data.size());
  for (std::size_t i = 0; i < image.data.size(); ++i) EXPECT_NEAR(png.data[i], image.data[i], 1e-6);

  Image grey(32, 32, 3);
  std::fill(grey.data.begin(), grey.data.end(), 0.5F);
  const std::string jpeg = encode_image(grey, ImageCode::kJpeg, 90);
  write_file_atomically(scratch / "a.jpg", jpeg);
  const Image back = read_image(scratch / "a.jpg");
  ASSERT_EQ(back.width, 32);
  for (const float v : back.data) EXPECT_NEAR(v, 0.5F, 0.02F);
}

}  // namespace
}  // namespace simuli
