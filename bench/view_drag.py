"""Measures the latency of the viewer's page during a drag: view_drag.py URL [picture|points]

URL: address of `simuli view SCENE`. A headless Chromium (controlled by playwright) drags 80 times in the page, 40 ms
apart: the camera picture, or the 3D view with the rendered picture in it. Prints the time in ms from a move of the
pointer to the picture that includes it.
"""
import statistics
import sys

from playwright.sync_api import sync_playwright

# A picture includes all moves before its request.
WATCH = """canvas => {
  const pane = canvas === 'picture' ? camera : photo, {load, paint} = pane;
  let moves = [];
  window.answers = [];
  document.getElementById(canvas).addEventListener('pointermove', e => { if (e.buttons) moves.push(performance.now()); }, true);
  pane.load = async () => { const mine = moves; moves = []; const loaded = await load(); return loaded && {...loaded, mine}; };
  pane.paint = loaded => { paint(loaded); for (const at of loaded.mine) answers.push(performance.now() - at); };
}"""


def main(url, canvas="picture"):
    with sync_playwright() as p:
        arguments = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = p.chromium.launch(executable_path="/usr/bin/chromium", args=arguments)
        page = browser.new_page(viewport={"width": 1600, "height": 1000})
        page.goto(url + ("#photo=true" if canvas == "points" else ""))
        for shown in ("#picture", "#points"):
            page.wait_for_selector(shown + "[data-frames]")
        page.wait_for_timeout(2000)
        page.evaluate(WATCH, canvas)
        box = page.locator("#" + canvas).bounding_box()
        for _ in range(2):
            x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 2
            page.mouse.move(x, y)
            page.mouse.down()
            for i in range(40):
                page.mouse.move(x + 4 * i, y + i / 2)
                page.wait_for_timeout(40)
            page.mouse.up()
            page.wait_for_timeout(1000)
        answers = sorted(page.evaluate("answers"))
        print(f"{canvas}: {len(answers)} moves, median {statistics.median(answers):.0f} ms, "
              f"90 % {answers[len(answers) * 9 // 10]:.0f}, longest {answers[-1]:.0f}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(*sys.argv[1:])
