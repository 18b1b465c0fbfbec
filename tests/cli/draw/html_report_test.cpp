#include "host/apps/cli/draw/html_report.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>

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

/// A report with one of everything.
HtmlReport whole_report() {
  HtmlReport report("title", "sub");
  report.heading("A & B");
  report.table({"a", "b"}, {{"1", "2"}});
  report.text_table({"a", ""}, {{"1", "words"}});
  report.folded_table("more", {"a", "b"}, {{"1", "2"}});
  report.heading("second");
  report.picture(ramp(4, 3), "a \"quoted\" one");
  report.picture(ramp(32, 16), "photo", PictureCode::kPhoto);
  report.compare(ramp(4, 3), "left", ramp(4, 3), "right", "b");
  report.paragraph("between");
  report.chart("c", "x", {{"s", {0.0, 1.0}, {2.0, 3.0}}, {"<t>", {0.0, 1.0}, {2.0, 1.0}}});
  report.bars("d", {"near", "far"}, {{"m", {}, {2.0, 3.0}}});
  report.cloud({{"one", "#ff0000", true, {1.0F, -2.0F, 3.0F, 4.0F, 5.0F, 6.0F}, {0.0F, 1.0F}},
                {"none", "#00ff00", true, {}, {}}},
               {CloudBox{}},
               "turn me");
  return report;
}

/// The tags that are open at some place of the page, without what browsers close themselves; "" for one that
/// closes what is not open.
std::string unbalanced(const std::string& html) {
  const std::set<std::string> without_end{"!doctype", "meta", "img", "br", "input"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "<";
    const bool closes = html[at + 1] == '/', is_single = html[end - 1] == '/';
    const std::size_t first = at + (closes ? 2 : 1);
    const std::string name = html.substr(first, html.find_first_of(" />\n", first) - first);
    if (closes) {
      if (open.empty() || open.back() != name) return "/" + name;
      open.pop_back();
    } else if (!is_single && !without_end.contains(name)) {
      open.push_back(name);
    }
    if (!closes && (name == "script" || name == "style")) at = html.find("</" + name, at) - 1;
  }
  return open.empty() ? "" : open.back();
}

TEST(HtmlReport, ClosesWhatItOpens) {
  EXPECT_EQ(unbalanced(whole_report().html()), "");
  EXPECT_EQ(unbalanced(HtmlReport("", "").html()), "");
  EXPECT_EQ(unbalanced("<p><b></p>"), "/p");
  EXPECT_EQ(unbalanced("<p><img>"), "p");
}

TEST(HtmlReport, NeedsNothingBesideItself) {
  const std::string html = whole_report().html();
  for (const char* outside :
       {"http:", "https:", "url(", "@import", "<link", "fetch(", "XMLHttpRequest", "import("})
    EXPECT_FALSE(holds(html, outside)) << outside;
  for (std::size_t at = html.find("src="); at != std::string::npos; at = html.find("src=", at + 1)) {
    EXPECT_EQ(html.compare(at, 16, "src=\"data:image/"), 0);
  }
  for (std::size_t at = html.find("href="); at != std::string::npos; at = html.find("href=", at + 1)) {
    EXPECT_EQ(html.compare(at, 12, "href=\"#part-"), 0);
  }
}

TEST(HtmlReport, LeadsToItsParts) {
  const std::string html = whole_report().html();
  EXPECT_TRUE(holds(html, "<a href=\"#part-1\">A &amp; B</a>"));
  EXPECT_TRUE(holds(html, "<h2 id=\"part-2\">second</h2>"));
}

TEST(HtmlReport, KeepsPhotosSmallAndTheRestAsItIs) {
  HtmlReport as_is("", ""), photo("", "");
  as_is.picture(ramp(200, 100), "a");
  photo.picture(ramp(200, 100), "a", PictureCode::kPhoto);
  EXPECT_TRUE(holds(as_is.html(), "src=\"data:image/png;base64,"));
  EXPECT_TRUE(holds(photo.html(), "src=\"data:image/jpeg;base64,"));
}

/// What a cloud's first layer says of its place, e.g. "data-count".
std::string attribute_of_layer(const std::string& html, const std::string& name) {
  const std::size_t at = html.find(name + "=\"", html.find("data-name")) + name.size() + 2;
  return html.substr(at, html.find('"', at) - at);
}

TEST(HtmlReport, ThinsCloudsEvenly) {
  CloudLayer layer{"one", "#ff0000"};
  constexpr std::size_t kPoints = 3 * CloudLayer::kMostPoints;
  for (std::size_t i = 0; i < kPoints; ++i) {
    for (int axis = 0; axis < 3; ++axis) layer.xyz.push_back(static_cast<float>(i));
    layer.intensity.push_back(0.5F);
  }
  HtmlReport report("", "");
  report.cloud({layer}, {}, "c");
  EXPECT_EQ(attribute_of_layer(report.html(), "data-count"), std::to_string(CloudLayer::kMostPoints));
  EXPECT_NEAR(std::stod(attribute_of_layer(report.html(), "data-step")), (kPoints - 1) / 32767.0, 1e-3);
  // 7 bytes a point, 4 characters for 3 of them.
  EXPECT_LT(report.html().size(), HtmlReport("", "").html().size() + CloudLayer::kMostPoints * 28 / 3 + 2000);
  HtmlReport without("", "");
  without.cloud({{"none", "#ff0000"}}, {}, "c");
  EXPECT_FALSE(holds(without.html(), "<canvas"));
}

TEST(HtmlReport, DrawsBarsFromTheirFoot) {
  HtmlReport report("title", "sub");
  report.bars("none", {"a"}, {{"m", {}, {std::numeric_limits<double>::quiet_NaN()}}});
  EXPECT_FALSE(holds(report.html(), "<rect"));
  report.bars("d", {"near", "far"}, {{"m", {}, {0.0, 3.0}}});
  EXPECT_TRUE(holds(report.html(), "<title>near m: 0</title>"));
  EXPECT_TRUE(holds(report.html(), "height=\"0.0\""));
  EXPECT_TRUE(holds(report.html(), "height=\"192.0\""));
}

/// One bin of four returns made all others of a chart one pixel high.
TEST(HtmlReport, ABarFarAboveTheOthersIsCutOff) {
  struct Case {
    std::vector<double> values;
    bool cut;
  };
  for (const Case& c : {Case{{5.5, 15.6, 47.0, 106.2, 2051.87}, true},
                        Case{{0.3, 0.4, 1.3, 1.4, 19.4}, true},
                        Case{{5.5, 15.6, 47.0, 106.2, 244.2}, false},  // grows with range
                        Case{{1.0, 2.0}, false},
                        Case{{0.0, 7.0}, false},
                        Case{{31.5, 30.9, 30.1, 28.2}, false}}) {
    HtmlReport report("title", "sub");
    report.bars("d", std::vector<std::string>(c.values.size(), "bin"), {{"m", {}, c.values}});
    EXPECT_EQ(holds(report.html(), "class=\"cut\""), c.cut) << c.values.back();
    EXPECT_EQ(holds(report.html(), ">2052</text>"), c.values.back() > 1000.0);
  }
}

/// The axis of curves is that of most points.
TEST(HtmlReport, OnePointFarAwayFlattensNoCurve) {
  struct Case {
    std::vector<double> y;
    int beyond;
  };
  std::vector<double> training;  // PSNR while training: a steep start is no outlier
  for (int i = 0; i < 100; ++i) training.push_back(32.0 - 12.0 * std::exp(-0.05 * i));
  for (const Case& c : {Case{{30.1, 30.2, 29.9, 30.0, 30.3, 30.1, 12.0, 30.2, 30.0, 30.1}, 1},
                        Case{{1.0, 1.1, 0.9, 1.0, 1.2, 1.1, 1.0, 950.0, 0.9, 1.0}, 1},
                        Case{{5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 6.0}, 1},
                        Case{{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0}, 0},
                        Case{{1.0, 900.0}, 0},
                        Case{training, 0}}) {
    HtmlReport report("title", "sub");
    std::vector<double> x(c.y.size());
    std::iota(x.begin(), x.end(), 0.0);
    report.chart("c", "x", {{"s", x, c.y}});
    const std::string html = report.html();
    int beyond = 0;
    for (std::size_t at = 0; (at = html.find("<polygon", at)) != std::string::npos; ++at) ++beyond;
    EXPECT_EQ(beyond, c.beyond) << c.y.front() << ' ' << c.y.size();
  }
}

/// A phone shows a wide table row by row, with the columns' names in it.
TEST(HtmlReport, CellsOfWideTablesKnowTheirColumn) {
  HtmlReport report("title", "sub");
  report.table({"", "a", "b", "c", "d <e>"}, {{"row", "1", "2", "3", "4"}});
  EXPECT_TRUE(holds(report.html(), "<td>row</td><td data-name=\"a\">1</td>"));
  EXPECT_TRUE(holds(report.html(), "<td data-name=\"d &lt;e&gt;\">4</td>"));
  HtmlReport narrow("title", "sub");
  narrow.table({"metric", "value", "unit"}, {{"PSNR", "30", "dB"}});
  EXPECT_FALSE(holds(narrow.html(), "<td data-name"));
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
