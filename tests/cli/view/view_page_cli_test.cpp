// The viewer's page in a real browser, where one is installed.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <chrono>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/cli/background_program.hpp"
#include "tests/cli/draw/browser.hpp"
#include "tests/cli/view/view_fixture.hpp"

namespace view_page_cli_test {

using namespace simuli::test;
using nlohmann::json;

/// The page in a browser.
class ViewPage : public ViewCli {
 protected:
  void TearDown() override {
    browser_.reset();  // writes to the folder until it ends
    driver_.reset();
    ViewCli::TearDown();
  }
  void open(const std::string& what) {
    start_scene(what);
    driver_ = std::make_unique<BackgroundProgram>(std::vector<std::string>{"chromedriver", "--port=0"},
                                                  folder_ / "driver.txt");
    const int driver_port = driver_->disoccluded_number("successfully on port ");
    ASSERT_GT(driver_port, 0) << driver_->output();
    browser_ = std::make_unique<Browser>(driver_port, folder_ / "profile");
    ASSERT_TRUE(browser_->is_open()) << driver_->output();
    go("");
  }
  /// The page with that behind its address.
  void go(const std::string& hash) {
    browser_->open("about:blank");
    browser_->open("http://localhost:" + std::to_string(port_) + "/" + hash);
    ASSERT_TRUE(
        browser_->wait_for("typeof $ === 'function' && +$('picture').dataset.frames > 0 && "
                           "+$('points').dataset.frames > 0"))
        << browser_->console().dump();
  }
  json tell(const std::string& expression) { return browser_->evaluate("return " + expression); }
  void act(const std::string& script) { browser_->evaluate(script); }
  void set(const std::string& id, const std::string& value, const char* event = "change") {
    act(fmt::format("$('{0}').value = '{1}'; $('{0}').dispatchEvent(new Event('{2}'))", id, value, event));
  }
  void key(const std::string& name, const std::string& more = "") {
    act(fmt::format("document.dispatchEvent(new KeyboardEvent('keydown', {{key: '{}', {}}}))", name, more));
  }
  /// Fingers that are put down, moved and lifted.
  void touch(const std::string& from, const std::string& to) {
    for (const auto& [kind, fingers] : {std::pair{"touchStart", from}, {"touchMove", to}, {"touchEnd", "[]"}})
      browser_->command("Input.dispatchTouchEvent", {{"type", kind}, {"touchPoints", json::parse(fingers)}});
  }
  /// Whether the canvas looks different within some seconds.
  bool changes(const std::string& canvas, const std::function<void()>& how) {
    const std::string look = "$('" + canvas + "').toDataURL()";
    const json before = tell(look);
    how();
    for (int tries = 0; tries < 200; ++tries) {
      if (tell(look) != before) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  void expect_no_errors() {
    for (const json& entry : browser_->console()) EXPECT_NE(entry.at("level"), "SEVERE") << entry.dump();
    EXPECT_EQ(tell("$('message').textContent"), "");
  }

  std::unique_ptr<BackgroundProgram> driver_;
  std::unique_ptr<Browser> browser_;
};

#define NEED_BROWSER()                                                   \
  if (const std::string missing = missing_browser(); !missing.empty()) { \
    GTEST_SKIP() << "not run: the page in a browser, " << missing;       \
  }

TEST_F(ViewPage, ShowsASceneAndKeepsItsLayout) {
  NEED_BROWSER();
  make_street_scene(3);
  open("s.scene");
  // The first frame is one at which everything sees, and both panes show that moment.
  EXPECT_EQ(tell("$('picture').dataset.time"), tell("$('points').dataset.time"));
  EXPECT_EQ(tell("state.time"), tell("Math.max(scene.frames.front[0][0], scene.frames.top[0][0])"));
  // The window is filled, and whatever is said nothing in it moves, at any size.
  const std::string layout =
      "JSON.stringify(['camera-pane', 'space-pane', 'time', 'picture', 'points'].map(id => { const r = "
      "$(id).getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; }))";
  for (const auto& [width, height] : {std::pair{1600, 1000}, {1280, 720}, {390, 844}}) {
    ASSERT_TRUE(browser_->resize_to(width, height));
    EXPECT_EQ(tell("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
              json({width, height}));
    EXPECT_EQ(tell("Math.round(document.querySelector('footer').getBoundingClientRect().bottom)"), height);
    EXPECT_GT(tell("$('picture').clientHeight + (innerWidth > 800 ? 0 : $('points').clientHeight)"),
              0.7 * height);
    // What a laptop has no room for would be missed; a phone's toolbars are scrolled.
    EXPECT_EQ(
        tell("innerWidth < 1000 || [...document.querySelectorAll('.tools')].every(e => e.scrollWidth <= "
             "e.clientWidth)"),
        true)
        << width;
    EXPECT_EQ(tell("['show-help', 'time', 'time-text'].every(id => $(id).getBoundingClientRect().right <= "
                   "innerWidth)"),
              true)
        << width;
    const json before = tell(layout);
    act("$('camera-time').textContent = 'x '.repeat(400); say('y '.repeat(400)); $('device').textContent = "
        "'z '.repeat(400)");
    EXPECT_EQ(tell(layout), before);
    act("say(''); $('device').textContent = ''");
  }
  ASSERT_TRUE(browser_->resize_to(1280, 720));
  browser_->drag(639, 300, 200, 0);
  EXPECT_NEAR(tell("$('camera-pane').clientWidth").get<double>(), 837.0, 8.0) << "resized";
  key("x");
  EXPECT_EQ(tell("[$('picture').clientWidth, $('points').clientWidth]"), json({1280, 0})) << "maximised";
  key("x");
  act("for (const theme of ['light', 'dark']) { state.theme = theme; showFields(); "
      "document.body.dataset[theme] = "
      "getComputedStyle(document.body).backgroundColor; }");
  EXPECT_NE(tell("document.body.dataset.light"), tell("document.body.dataset.dark"));
  key("?");
  EXPECT_EQ(tell("$('help').open && $('keys').rows.length === kKeys.length"), true);
  act("$('help').close()");
  EXPECT_TRUE(changes("picture", [&] { set("layer", "depth"); }));
  EXPECT_TRUE(browser_->wait_for("$('camera-scale').textContent.includes(' m')"));
  EXPECT_TRUE(changes("picture", [&] { browser_->drag(200, 300, 80, 20); })) << "look around";
  EXPECT_TRUE(changes("points", [&] { browser_->drag(1000, 300, 80, 20); })) << "orbit";
  // On a slow device pictures are small while something moves, and sharp when it rests.
  act("widths = []; const paint = camera.paint; camera.paint = what => { paint(what); "
      "widths.push(what.bitmap.width); }; "
      "haste.camera.took = () => {}; haste.camera.at = 4");
  browser_->drag(200, 300, 80, 20);
  EXPECT_TRUE(browser_->wait_for("widths.includes(240) && widths.at(-1) === 960"));
  EXPECT_EQ(tell("Math.min(...widths)"), 240);
  EXPECT_TRUE(changes("points", [&] { set("lidar", "velodyne_vlp16"); }));
  EXPECT_TRUE(changes("points", [&] { set("colour", "ring"); }));
  act("$('clip').click()");
  EXPECT_EQ(tell("$('clip').textContent"), "stop");
  EXPECT_TRUE(changes("picture", [&] { key("End"); }));
  act("$('clip').click()");
  EXPECT_TRUE(browser_->wait_for("+$('clip').dataset.bytes > 0"));
  expect_no_errors();
  // What is written below the picture is about that picture, also while the next one is under way.
  const json stays = browser_->evaluate(
      "const held = fetch; window.fetch = (...a) => String(a[0]).includes('picture') ? new Promise(() => {}) "
      ": held(...a); const before = $('camera-time').textContent; $('camera').value = "
      "'pandaset_front_camera'; "
      "$('camera').onchange(); return [before, $('camera-time').textContent, $('picture').className]");
  EXPECT_EQ(stays.at(0), stays.at(1));
  EXPECT_EQ(stays.at(0).get<std::string>().rfind("front, balanced, depth", 0), 0U) << stays;
  EXPECT_EQ(stays.at(2), "stale");
  EXPECT_TRUE(browser_->wait_for("$('camera-note').textContent.includes('...')"));
}

TEST_F(ViewPage, TimeEditsAndAddressAreKept) {
  NEED_BROWSER();
  make_street_scene(3);
  open("s.scene");
  key("Home");
  EXPECT_EQ(tell("$('time-text').textContent.startsWith('frame 0 of ')"), true);
  key("ArrowRight");
  EXPECT_EQ(tell("state.time"), tell("scene.frames.front[1][0]"));
  key("End");
  EXPECT_EQ(tell("state.time"), tell("scene.frames.front.at(-1)[0]"));
  // Every frame is shown, in its turn, and without a loop the last one stays.
  act("key = name => document.dispatchEvent(new KeyboardEvent('keydown', {key: name})); shown = []; const "
      "paint = camera.paint;"
      "camera.paint = what => { paint(what); shown.push(what.info.time_s); }; key('Home'); key('e'); "
      "key('l'); state.speed = '4';");
  act("played = false; panes.ask(['camera']).then(() => { shown = []; return play(); }).then(() => { played "
      "= true; })");
  EXPECT_TRUE(browser_->wait_for("played && !playing"));
  EXPECT_EQ(tell("JSON.stringify(shown) === JSON.stringify(scene.frames.front.slice(1).map(f => f[0]))"),
            true)
      << tell("shown");
  // As fast as the log, round and round: also where a picture takes longer than the drive.
  act("moments = []; key('e'); key('l'); state.speed = '1000'; play()");
  EXPECT_TRUE(browser_->wait_for("moments.push(state.time) && new Set(moments).size > 2"));
  act("play(); state.speed = '1'");
  // After a click on a button Space plays.
  const json at = tell("(({x, y}) => [x + 5, y + 5])($('on').getBoundingClientRect())");
  browser_->drag(at.at(0).get<int>(), at.at(1).get<int>(), 0, 0);
  EXPECT_EQ(tell("document.activeElement === document.body"), true);
  // Undo, redo and reset; rows and boxes are chosen together.
  act("$('show-actors').click(); document.querySelector('[data-row=car]').click()");
  EXPECT_EQ(tell("[selected, document.querySelector('[data-row=car]').className]"),
            json({"car", "actor selected"}));
  EXPECT_TRUE(changes("points", [&] {
    act("const e = document.querySelector('[data-edit=\"car turned\"]'); e.value = 60; e.onchange(); "
        "settle()");
  }));
  key("Delete");
  act("settle()");
  EXPECT_EQ(tell("state.edits.removed"), json({"car"}));
  EXPECT_EQ(tell("document.querySelector('[data-actor]').checked"), false);
  key("z", "ctrlKey: true");
  EXPECT_EQ(tell("[state.edits.removed, state.edits.turned.car]"), json({json::array(), 60}));
  key("z", "ctrlKey: true");
  EXPECT_EQ(tell("state.edits.turned"), json::object());
  key("Z", "ctrlKey: true, shiftKey: true");
  EXPECT_EQ(tell("state.edits.turned.car"), 60);
  act("document.querySelector('[data-duplicate]').click()");
  EXPECT_TRUE(browser_->wait_for("document.querySelectorAll('[data-actor]').length === 2"));
  act("undo()");
  EXPECT_EQ(tell("state.edits.removed"), json({"car_2"})) << "it was not there before";
  act("redo(); $('reset').click(); settle()");
  EXPECT_EQ(tell("[state.edits.removed, state.edits.moved, state.edits.turned]"),
            json({{"car_2"}, json::object(), json::object()}));
  // A reload shows the same.
  act("undo(); set = (k, v) => { state[k] = v; }; set('left', 0.5); set('layer', 'opacity'); "
      "points.orbit.turn(1, 0); "
      "orbited(); settle()");
  const json hash = tell("location.hash");
  const json before = tell("JSON.stringify(state)");
  go(hash.get<std::string>());
  EXPECT_EQ(tell("JSON.stringify(state)"), before);
  EXPECT_EQ(tell("points.orbit.azimuth"), tell("state.orbit.azimuth"));
  // An address that nobody wrote is said to be none.
  go("#time=x&edits=%7B%7D&orbit=%7B%7D");
  EXPECT_EQ(tell("$('message').textContent.includes('address: time')"), true);
}

TEST_F(ViewPage, PointsToWhatIsThere) {
  NEED_BROWSER();
  make_street_scene(3);
  open("s.scene");
  ASSERT_TRUE(browser_->resize_to(1280, 720));
  // The car's box, its name and the cameras are in the 3D view; a value is read from a point and from a pixel.
  EXPECT_EQ(tell("points.boxes[0].name + (points.lines.length - 1)"), "car1");
  const std::string on_a_point =
      "const p = points.points.subarray(0, 7), at = points.orbit.project([...p], points.aspect), r = "
      "$('points').getBoundingClientRect(); const e = {clientX: r.left + at[0] * r.width, clientY: r.top + "
      "at[1] * "
      "r.height, pane: 'space'};";
  act("points.orbit.target = [...points.points.subarray(0, 3)]; points.orbit.distance = 8; orbited();" +
      on_a_point + "read(e)");
  EXPECT_TRUE(browser_->wait_for("$('lidar-reading').textContent.includes('intensity')"));
  const std::string pixel =
      "const r = $('picture').getBoundingClientRect(), e = {clientX: r.left + r.width / 2, "
      "clientY: r.top + r.height * 0.65, pane: 'picture'};";
  act(pixel + "read(e)");
  EXPECT_TRUE(browser_->wait_for("$('camera-reading').textContent.includes('opacity')"));
  EXPECT_EQ(tell("/support \\d/.test($('camera-reading').textContent)"), true);
  // The 3D view turns about what the pointer is on.
  act(pixel + "lastPointer = e; focused = points.orbit.target; focus().then(() => { focused = null; })");
  EXPECT_TRUE(browser_->wait_for("focused === null"));
  act(pixel + "pick(e, 'picture').then(found => { picked = found.point; })");
  EXPECT_TRUE(browser_->wait_for("typeof picked === 'object'"));
  EXPECT_EQ(tell("points.orbit.target"), tell("picked"));
  // Between two places.
  act("key = name => document.dispatchEvent(new KeyboardEvent('keydown', {key: name})); key('m');" + pixel +
      "mark(e, 'picture').then(() => mark({...e, clientX: e.clientX + 60}, 'picture'))");
  EXPECT_TRUE(browser_->wait_for("/^\\d+\\.\\d+ m \\(/.test($('camera-reading').textContent)"));
  EXPECT_EQ(tell("Math.abs(Math.hypot(...sub(marks[0].point, marks[1].point)) - "
                 "parseFloat($('camera-reading').textContent)) < 1e-3"),
            true);
  act("was = $('camera-reading').textContent; done = false;" + pixel +
      "read(e).then(() => { done = true; })");
  EXPECT_TRUE(browser_->wait_for("done"));
  EXPECT_EQ(tell("$('camera-reading').textContent"), tell("was"));
  key("Escape");
  EXPECT_EQ(tell("marks.length"), 0);
  // A box is dragged along its ground, by whole millimetres.
  act("Object.assign(points.orbit, structuredClone(usual.orbit)); orbited()");
  const json box = tell(
      "(r => { const [x, y] = points.orbit.project(points.boxes[0].t, points.aspect); "
      "return [r.left + x * r.width, r.top + y * r.height]; })($('points').getBoundingClientRect())");
  act("settle(); steps = past.before.length");
  browser_->drag(box.at(0).get<int>(), box.at(1).get<int>(), 30, 4, 600);
  act("settle()");
  EXPECT_EQ(tell("past.before.length - steps"), 1) << "a drag that rests on its way is one step";
  EXPECT_EQ(tell("state.edits.moved.car.length"), 3);
  EXPECT_EQ(tell("[state.edits.moved.car[2], state.edits.moved.car.every(v => v === +v.toFixed(3))]"),
            json({0, true}));
  EXPECT_NE(tell("Math.hypot(...state.edits.moved.car)"), 0);
  act("$('actors-view').hidden = true");  // the box's row was shown
  // The scene behind the points, from where the orbit is.
  EXPECT_TRUE(changes("photo", [&] { key("p"); }));
  act("maximise('space')");
  EXPECT_TRUE(browser_->wait_for("Math.abs($('photo').width / $('photo').height - points.aspect) < 0.02"))
      << "of the pane's shape";
  act("maximise('space')");
  EXPECT_TRUE(browser_->wait_for("Math.abs($('photo').width / $('photo').height - points.aspect) < 0.02"));
  // One finger turns, two pan and pinch.
  act("was = structuredClone({...points.orbit})");
  touch(R"([{"x": 900, "y": 300, "id": 1}])", R"([{"x": 950, "y": 300, "id": 1}])");
  EXPECT_EQ(tell("points.orbit.azimuth !== was.azimuth && points.orbit.distance === was.distance"), true);
  act("was = structuredClone({...points.orbit})");
  touch(R"([{"x": 900, "y": 300, "id": 1}, {"x": 1000, "y": 300, "id": 2}])",
        R"([{"x": 880, "y": 350, "id": 1}, {"x": 1080, "y": 350, "id": 2}])");
  EXPECT_EQ(tell("points.orbit.azimuth === was.azimuth && points.orbit.distance < 0.7 * was.distance && "
                 "points.orbit.target[2] !== was.target[2]"),
            true)
      << tell("[points.orbit, was]");
  // The returns lie over the picture, too.
  EXPECT_TRUE(changes("picture-over", [&] { act("document.querySelector('[data-state=over]').click()"); }));
  EXPECT_TRUE(browser_->wait_for("seen.points.length > 900"));
  // Each view has its command; it is gone when another view is shown.
  act("$('lidar-command').click()");
  EXPECT_TRUE(browser_->wait_for("$('command-box').open && $('command').value.includes('view_free.json')"));
  act("$('command-box').close()");
  act("showCommand(pictureRequest())");
  EXPECT_TRUE(browser_->wait_for("$('command-box').open && $('command').value.startsWith('simuli render')"));
  act("$('layer').value = 'depth'; $('layer').onchange()");
  EXPECT_EQ(tell("$('command-box').open"), false);
  expect_no_errors();
}

TEST_F(ViewPage, TakesWhatItsHelpSays) {
  NEED_BROWSER();
  make_street_scene(3);
  open("s.scene");
  ASSERT_TRUE(browser_->resize_to(1280, 720));
  EXPECT_TRUE(changes("points", [&] { set("size", "6"); }));
  EXPECT_EQ(tell("state.size"), 6);
  set("colour", "intensity");
  EXPECT_TRUE(browser_->wait_for("$('lidar-scale').textContent.includes('square root')"));
  // Keys move what was clicked last: the picture's camera, or what the 3D view turns about.
  browser_->drag(100, 300, 0, 0);
  act("was = [state.forward, state.left, state.up]");
  for (const char* name : {"w", "a", "PageUp"}) key(name);
  EXPECT_EQ(tell("[state.forward > was[0], state.left > was[1], state.up > was[2]]"),
            json({true, true, true}));
  key("r");
  EXPECT_EQ(tell("[state.forward, state.left, state.up, state.yaw, state.pitch]"), json({0, 0, 0, 0, 0}));
  browser_->drag(1000, 600, 0, 0);
  act("was = JSON.stringify(points.orbit.target)");
  key("w");
  EXPECT_EQ(tell("[JSON.stringify(points.orbit.target) !== was, state.forward]"), json({true, 0}));
  // The wheel goes nearer, a double click turns about a point.
  act("was = points.orbit.distance; $('points').dispatchEvent(new WheelEvent('wheel', {deltaY: -300, "
      "clientX: 900, "
      "clientY: 300, cancelable: true}))");
  EXPECT_EQ(tell("points.orbit.distance < was"), true);
  act("points.orbit.target = [...points.points.subarray(0, 3)]; points.orbit.distance = 8; orbited();"
      "was = JSON.stringify(points.orbit.target); const at = "
      "points.orbit.project([...points.points.subarray(7, 10)], "
      "points.aspect), r = $('points').getBoundingClientRect(); $('points').dispatchEvent(new "
      "MouseEvent('dblclick', "
      "{clientX: r.left + at[0] * r.width, clientY: r.top + at[1] * r.height, bubbles: true}))");
  EXPECT_TRUE(browser_->wait_for("JSON.stringify(points.orbit.target) !== was"));
  // What a key turns on it turns off again.
  for (const auto& [name, what] : {std::pair{"b", "boxes"}, {"l", "loop"}, {"e", "every"}}) {
    act(fmt::format("was = state.{}", what));
    key(name);
    EXPECT_EQ(tell(fmt::format("state.{} === !was", what)), true) << name;
    key(name);
    EXPECT_EQ(tell(fmt::format("state.{} === was", what)), true) << name;
  }
  act("$('time').value = 0.4; $('time').oninput()");
  EXPECT_TRUE(browser_->wait_for("state.time === 0.4 && Math.abs($('picture').dataset.time - 0.4) < 0.06"));
  // On the picture one finger looks around and two go on.
  act("was = state.yaw");
  touch(R"([{"x": 200, "y": 300, "id": 1}])", R"([{"x": 260, "y": 300, "id": 1}])");
  EXPECT_EQ(tell("state.yaw !== was"), true);
  act("was = state.forward");
  touch(R"([{"x": 200, "y": 300, "id": 1}, {"x": 300, "y": 300, "id": 2}])",
        R"([{"x": 170, "y": 300, "id": 1}, {"x": 330, "y": 300, "id": 2}])");
  EXPECT_EQ(tell("state.forward > was"), true);
  // Each layer is shown, by its name.
  for (const char* layer : {"depth", "opacity", "support"}) {
    set("layer", layer);
    EXPECT_TRUE(browser_->wait_for(fmt::format("$('camera-time').textContent.includes('{}')", layer)));
  }
  EXPECT_TRUE(browser_->wait_for("$('camera-scale').textContent.includes('as recorded')"));
  expect_no_errors();
}

TEST_F(ViewPage, ComesBackWithItsServer) {
  NEED_BROWSER();
  make_street_scene(3);
  open("s.scene");
  const std::string port = std::to_string(port_);
  viewer_.reset();
  key("ArrowRight");
  EXPECT_TRUE(browser_->wait_for("$('message').textContent.includes('trying again')"));
  viewer_ = std::make_unique<BackgroundProgram>(
      std::vector<std::string>{SIMULI_PROGRAM, "view", (folder_ / "s.scene").string(), "--port", port},
      folder_ / "again.txt");
  EXPECT_TRUE(
      browser_->wait_for("$('message').textContent === '' && !panes.running && "
                         "Math.abs($('picture').dataset.time - state.time) < 1e-9"));
}

TEST_F(ViewPage, ShowsALog) {
  NEED_BROWSER();
  make_street();
  open("s.log");
  EXPECT_GT(tell("seen.points.length"), 900);
  EXPECT_EQ(tell("$('layer').closest('label').hidden"), true);
  EXPECT_TRUE(changes("picture-over", [&] { set("colour", "intensity"); }));
  EXPECT_TRUE(changes("points", [&] { set("sweeps", "3"); }));
  EXPECT_TRUE(changes("picture", [&] { key("End"); }));
  expect_no_errors();
}

}  // namespace view_page_cli_test
