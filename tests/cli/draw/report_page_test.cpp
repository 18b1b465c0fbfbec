// What a report does in a browser.
#include <chrono>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <thread>

#include "host/apps/cli/draw/html_report.hpp"
#include "tests/cli/background_program.hpp"
#include "tests/cli/draw/browser.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

Image grey(int width, int height, float value) {
  Image image(width, height, 3);
  std::fill(image.data.begin(), image.data.end(), value);
  return image;
}

void write_page(const std::filesystem::path& file) {
  HtmlReport report("a report with a title that is longer than a phone is wide", "sub");
  report.heading("pictures");
  report.compare(grey(320, 180, 0.2F), "left", grey(320, 180, 0.8F), "right", "a pair");
  report.picture(grey(2000, 64, 0.5F), "a wide one");
  report.heading("numbers");
  report.table(std::vector<std::string>(14, "a column"), {std::vector<std::string>(14, "123.456")});
  report.folded_table("folded", {"key", "value"}, {{"inside", std::string(300, 'x')}});
  report.chart("curve", "x", {{"s", {0.0, 1.0}, {2.0, 3.0}}});
  report.heading("points");
  CloudLayer ring{"ring", "#ff0000"}, line{"line", "#00ff00"};
  for (int i = 0; i < 2000; ++i) {
    const float angle = 0.01F * static_cast<float>(i), height = -0.001F * static_cast<float>(i);
    ring.xyz.insert(ring.xyz.end(), {12.0F + 5.0F * std::cos(angle), 5.0F * std::sin(angle), height});
    ring.intensity.push_back(0.5F);
    line.xyz.insert(line.xyz.end(), {0.02F * static_cast<float>(i), 1.0F, 0.0F});
    line.intensity.push_back(0.1F);
  }
  report.cloud({ring, line}, {CloudBox{}}, "turn");
  report.write(file);
}

TEST(ReportPage, WorksInABrowser) {
  if (const std::string missing = test::missing_browser(); !missing.empty()) {
    GTEST_SKIP() << "not run: reports in a browser, " << missing;
  }
  const test::Scratch scratch;
  write_page(scratch / "r.html");
  const test::BackgroundProgram driver({"chromedriver", "--port=0"}, scratch / "driver.txt");
  const int port = driver.disoccluded_number("successfully on port ");
  ASSERT_GT(port, 0) << driver.output();
  test::Browser browser(port, scratch / "profile");
  ASSERT_TRUE(browser.is_open()) << driver.output();
  browser.open("file://" + std::filesystem::absolute(scratch / "r.html").string());
  const auto run = [&](const std::string& script) { return browser.evaluate(script); };
  ASSERT_TRUE(browser.wait_for("document.querySelector('canvas')?.dataset.frames > 0"))
      << browser.console().dump();

  // The line between two pictures follows the mouse and the keys.
  const nlohmann::json at =
      run("const b = document.querySelector('.pair').getBoundingClientRect(); "
          "return [Math.round(b.left), Math.round(b.top), Math.round(b.width)]");
  const int left = at.at(0), top = at.at(1), width = at.at(2);
  browser.drag(left + width / 2, top + 60, width / 4, 0);
  const std::string line = "return +document.querySelector('.pair').getAttribute('aria-valuenow')";
  // Browsers tell of movements when they draw the next time.
  EXPECT_TRUE(
      browser.wait_for("Math.abs(+document.querySelector('.pair').getAttribute('aria-valuenow') - 75) <= 1"));
  run("const e = new KeyboardEvent('keydown', {key: 'ArrowLeft', bubbles: true}); "
      "document.querySelector('.pair').dispatchEvent(e)");
  EXPECT_NEAR(run(line).get<double>(), 70.0, 1.0);

  // Pictures open as large as the window, and larger.
  run("document.querySelectorAll('.enlarge')[0].click()");
  EXPECT_EQ(run("return document.querySelector('dialog p span').textContent"), "a pair");
  // The event of a closing comes after the next opening here.
  run("window.closings = 0; "
      "document.querySelector('dialog').addEventListener('close', () => ++window.closings); "
      "document.querySelector('[data-close]').click(); document.querySelectorAll('.enlarge')[1].click()");
  ASSERT_TRUE(browser.wait_for("window.closings === 1"));
  const std::string shown = "return document.querySelector('dialog[open] .stage > *')?.clientWidth ?? 0";
  const double fit = run(shown);
  EXPECT_GT(fit, 1000.0);
  EXPECT_LE(fit, run("return innerWidth").get<double>());
  run("document.querySelector('[data-size]').click()");
  EXPECT_GT(run(shown).get<double>(), 1.5 * fit);
  run("document.querySelector('[data-close]').click()");
  EXPECT_EQ(run(shown), 0);
  run("document.querySelector('.shot > img').click()");
  EXPECT_GT(run(shown).get<double>(), 0.0);
  run("document.querySelector('[data-close]').click()");

  // Points turn, are coloured otherwise, go away.
  const std::string pixels = "return document.querySelector('canvas').toDataURL()";
  const auto changes = [&](const std::string& act) {
    const nlohmann::json before = run(pixels);
    run(act);
    return run(pixels) != before;
  };
  run("document.querySelector('canvas').scrollIntoView({block: 'center'})");
  const nlohmann::json cloud =
      run("const b = document.querySelector('canvas').getBoundingClientRect(); return [b.left, "
          "b.top].map(Math.round)");
  const nlohmann::json before = run(pixels);
  browser.drag(cloud.at(0).get<int>() + 200, cloud.at(1).get<int>() + 150, 80, 20);
  bool is_turned = false;
  for (int tries = 0; tries < 100 && !is_turned; ++tries) {
    is_turned = run(pixels) != before;
    if (!is_turned) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_TRUE(is_turned);
  EXPECT_TRUE(changes("document.querySelector('.tools input').click()"));
  EXPECT_TRUE(changes("const s = document.querySelector('.tools select'); s.value = 'range'; s.onchange()"));
  for (int button = 0; button < 4; ++button) {
    EXPECT_TRUE(changes(fmt::format("document.querySelectorAll('.tools button')[{}].click()", button)))
        << button;
  }

  // On paper the cloud is on white, and what is folded is left out.
  EXPECT_TRUE(changes("dispatchEvent(new Event('beforeprint'))"));
  EXPECT_EQ(run("return document.querySelectorAll('details[open]').length"), 0);
  run("dispatchEvent(new Event('afterprint'))");
  run("document.querySelector('details').open = true");
  browser.command("Emulation.setEmulatedMedia", {{"media", "print"}});
  EXPECT_EQ(run("return document.querySelector('details').clientHeight"), 0);
  browser.command("Emulation.setEmulatedMedia", {{"media", ""}});

  // No wider than a phone, and nothing in it has to be scrolled aside.
  EXPECT_TRUE(browser.resize_to(390, 800));
  EXPECT_LE(run("return document.documentElement.scrollWidth").get<int>(), 390);
  EXPECT_EQ(run("return [...document.querySelectorAll('.scroll')].filter(s => s.scrollWidth > "
                "s.clientWidth).length"),
            0);
  for (const auto& entry : browser.console()) EXPECT_NE(entry.at("level"), "SEVERE") << entry;
}

}  // namespace
}  // namespace simuli
