"""The checks of the page of `gmlvm view` in a browser; run by browser.rs as
browser.py GMLVM CHROMIUM DIRECTORY SCREENSHOTS."""

import json
import math
import os
import struct
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlparse

from playwright.sync_api import sync_playwright

GMLVM, CHROMIUM, DIRECTORY, SHOTS = sys.argv[1], sys.argv[2], Path(sys.argv[3]), Path(sys.argv[4])
PATIENCE_MS = 60_000

# Its text tries to leave its place in the page.
SCENE = """% </script><script>document.title = 'owned'</script> <img src=x onerror="document.title = 'owned'">
{ /factor
  { /v /u /face
    u v mulf /product
    product product 0.5 point
    v 0.25 1.0 } } /made
"<img src=x onerror=document.title='owned'>" /trap
{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 } /plain
0.5 0.5 0.5 point [] 0.5 made apply sphere 0.0 0.0 2.0 translate
plain plane 0.0 -1.0 0.0 translate union 1 90.0 64 48 "a.ppm" render
"""
PRODUCT_LINE, OBJECT_LINE = 4, 9


def check(is_so, what):
    if not is_so:
        raise SystemExit(f"not so: {what}")


class Page:
    """A page of the server, of which every request and every complaint is noted."""

    def __init__(self, browser, address, width=1280, height=800, scheme="light"):
        self.page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.on("console", self.heard)
        self.page.on("pageerror", lambda error: complaints.append(str(error)))
        self.page.on("request", lambda request: hosts.add(urlparse(request.url).hostname))
        self.page.goto(address)
        self.wait("document.body.dataset.run !== undefined")

    def heard(self, message):
        if message.type in ("error", "warning"):
            complaints.append(message.text)

    def wait(self, condition):
        """The page's policy forbids what Playwright's own waiting does."""
        end = time.monotonic() + PATIENCE_MS / 1000
        while not self.ask(f"Boolean({condition})"):
            check(time.monotonic() < end, condition)
            time.sleep(0.02)

    def ask(self, expression):
        return self.page.evaluate(expression)

    def run(self, act):
        """Does what begins a run, and waits for the end of it."""
        run = int(self.ask("document.body.dataset.run"))
        act()
        self.wait(f"Number(document.body.dataset.run) > {run}")

    def type(self, text):
        """Replaces the text of the editor, and waits for the end of its run."""
        self.run(lambda: self.page.fill("#text", text))

    def pixels(self):
        """All bytes of the image that is shown."""
        return self.ask("""(() => {
            const canvas = document.getElementById("picture");
            const all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            return Array.from(all).filter((_, index) => index % 4 < 3); })()""")

    def file(self):
        """The bytes of the PNG file behind it."""
        return bytes(self.ask("""(async () => {
            const number = document.getElementById("picture").dataset.number;
            const response = await fetch("file/" + number);
            return Array.from(new Uint8Array(await response.arrayBuffer())); })()"""))


def rendered():
    """What `gmlvm run` makes of the scene: the file, and its pixels."""
    def run(format):
        line = [GMLVM, "run", "s.gml", "--format", format, "--output", "-", "-q"]
        return subprocess.run(line, cwd=DIRECTORY, capture_output=True, check=True).stdout
    return run("png"), list(run("ppm").split(b"\n255\n", 1)[1])


def errors_keep_the_image(page):
    png, pixels = rendered()
    page.wait("document.getElementById('picture').dataset.run")
    check(page.pixels() == pixels, "the image is that of gmlvm run")
    check(page.file() == png, "and so is its file")
    broken = SCENE.replace("0.5 0.5 0.5 point []", "0.5 0.5 radius point []")
    page.type(broken)
    page.wait("document.getElementById('status').dataset.state === 'bad'")
    line = page.ask("document.querySelector('#squiggles .primary').dataset.line")
    check(int(line) == OBJECT_LINE, f"the squiggle is at line {line}")
    squiggle = page.page.locator("#squiggles .primary").bounding_box()
    page.page.mouse.move(squiggle["x"] + squiggle["width"] / 2, squiggle["y"] + 8)
    tip = page.page.inner_text("#tip")
    check("radius" in tip and "is not bound" in tip, f"the text at the squiggle is {tip}")
    check(page.ask("document.getElementById('stack').classList.contains('stale')"), "the image is greyed")
    check(page.pixels() == pixels, "the last good image is kept")
    page.page.click("[role=tab][data-tab=problems]")
    page.page.click("#problems button")
    selected = page.ask("(t => t.value.slice(t.selectionStart, t.selectionEnd))(document.getElementById('text'))")
    check(selected == "radius", f"a click selects {selected}")
    page.type("{ radius 1 } /inner { inner apply 1 } /outer outer apply")
    page.wait("document.getElementById('problems').textContent.includes('in `outer`')")
    calls = page.ask("document.getElementById('problems').textContent")
    check("times more" not in calls, f"a call that stands once: {calls}")
    page.type("{ /self /n n 0 eqi { radius } { n 1 subi self self apply } if 1 addi } /down 4 down down apply")
    page.wait("document.getElementById('problems').textContent.includes(', 3 times more')")
    page.type(SCENE.replace("0.25 1.0", "0.75 1.0"))
    page.wait("document.getElementById('status').dataset.state === 'good'")
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")
    check(page.pixels() != pixels, "what is typed is rendered")
    page.type(SCENE)
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")
    check((page.file(), page.pixels()) == (png, pixels), "the repaired image is that of gmlvm run")
    check(not page.page.query_selector("#squiggles div"), "nothing is underlined any more")


def code_is_linked(page):
    page.page.click("[role=tab][data-tab=code]")
    page.page.wait_for_selector("#clif .linked", state="attached")
    row = page.page.locator("#clif .linked", has_text="fmul").first
    row.scroll_into_view_if_needed()
    row.hover()
    lit = page.ask("[...document.querySelectorAll('#bands div')].map((band) => Number(band.dataset.line))")
    check(lit == [PRODUCT_LINE], f"a line of CLIF lights lines {lit}")
    for form in ("clif", "bytecode"):
        same = page.ask(f"[...document.querySelectorAll('#{form} .same')].map((row) => row.textContent)")
        check(same and any("mul" in text.lower() for text in same), f"{form}: {same}")
    page.page.mouse.move(5, 5)
    text = page.page.locator("#text").bounding_box()
    page.ask("document.getElementById('text').scrollTop = 0")
    style = page.ask("parseFloat(getComputedStyle(document.getElementById('text')).paddingTop)")
    page.page.mouse.move(text["x"] + 60, text["y"] + style + 19 * (PRODUCT_LINE - 0.5))
    for form in ("clif", "bytecode", "asm"):
        near = page.ask(f"[...document.querySelectorAll('#{form} .near')].map((row) => row.textContent)")
        check(near, f"a line of the source lights no {form}")
    check(any("fmul" in text for text in page.ask("[...document.querySelectorAll('#clif .near')].map((r) => r.textContent)")), "the multiplication is lit")


def pixels_are_explained(page):
    box = page.page.locator("#picture").bounding_box()
    page.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.wait("document.getElementById('pixel').textContent.includes('certain')")
    about = page.page.inner_text("#pixel")
    for word in ("sphere 0", "surface 0", "colour", "ray", "instructions", "s.gml:3"):
        check(word in about, f"{word} is missing from {about}")
    lit = page.ask("[...document.querySelectorAll('#bands div')].map((band) => Number(band.dataset.line))")
    check(lit == [3, 4, 5, 6], f"the pixel lights lines {lit}")


def hostile_text_stays_text(page):
    check(page.ask("document.title") == "s.gml – gmlvm", page.ask("document.title"))
    inline = page.ask("[...document.scripts].filter((script) => !script.src.endsWith('/chart.js')).length")
    check(inline == 1, "there is another script")
    check(page.ask("[...document.images].every((image) => image.src.includes('/file/'))"), "there is another image")
    check("</script><script>" in page.ask("document.getElementById('colors').textContent"), "the text is not shown")


def changes_on_disk_arrive(page, scene):
    before = int(page.ask("document.body.dataset.revision"))
    (DIRECTORY / "s.gml").write_text(scene)
    page.wait(f"Number(document.body.dataset.revision) > {before}")
    check(page.ask("document.getElementById('text').value") == scene, "the editor has the new text")
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")


def edits_are_saved(page):
    edited = SCENE + "% saved\n"
    page.type(edited)
    check(page.page.is_visible("#dirty"), "it is not told that the text is not saved")
    page.page.press("#text", "Control+s")
    page.page.wait_for_selector("#dirty", state="hidden")
    check((DIRECTORY / "s.gml").read_text() == edited, "the file is written")
    # Somebody else saves while there are edits here.
    page.type(edited + "% mine\n")
    (DIRECTORY / "s.gml").write_text(SCENE)
    page.page.wait_for_selector("#take")
    check(page.ask("document.getElementById('text').value").endswith("% mine\n"), "edits are lost")
    page.page.click("#take")
    check(page.ask("document.getElementById('text').value") == SCENE, "the file is taken")


def light(*options):
    """The light of the scene as `gmlvm run` has it: numbers, row by row from the upper left."""
    line = [GMLVM, "run", "s.gml", "--format", "pfm", "--output", "-", "-q", *options]
    file = subprocess.run(line, cwd=DIRECTORY, capture_output=True, check=True).stdout
    rows = file.split(b"\n-1.0\n", 1)[1]
    size = 12 * 64
    upright = b"".join(rows[at:at + size] for at in range(len(rows) - size, -1, -size))
    return struct.unpack(f"<{len(upright) // 4}f", upright)


def layer(page, name):
    """Red, green and blue of all pixels of a canvas."""
    return page.ask(f"""(() => {{
        const canvas = document.getElementById("{name}");
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", {{ willReadFrequently: true }});
        copy.drawImage(canvas, 0, 0);
        const all = copy.getImageData(0, 0, canvas.width, canvas.height).data;
        return Array.from(all).filter((_, index) => index % 4 < 3); }})()""")


def show(page, what):
    """Chooses what lies over the image, and waits for it; returns how it is explained."""
    page.page.select_option("#shows", what)
    page.wait(f"(document.body.dataset.shown || '').split(' ')[1] === '{what}'")
    return page.page.inner_text("#legend").replace("\n", " ")


def images_are_looked_at_closely(page):
    fetched = page.ask("[...document.scripts].some((script) => script.src.endsWith('compare.js'))")
    check(not fetched, "what compares images is fetched too early")
    page.page.click("#inspect")
    page.page.wait_for_selector("#shows")

    # Exposure is a factor of the light, before that becomes bytes.
    page.ask("(stops => { stops.value = 1; stops.dispatchEvent(new Event('input')); })(document.getElementById('stops'))")
    page.wait("(document.body.dataset.shown || '').split(' ')[2] === '1'")
    brighter = [min(255, max(0, math.floor(2 * 255 * number))) for number in light()]
    check(layer(page, "overlay") == brighter, "the image is not a stop brighter")
    page.page.press("#stops", "ArrowLeft")
    page.page.press("#stops", "ArrowLeft")
    page.wait("(document.body.dataset.shown || '').split(' ')[2] === '0'")
    check(not page.page.is_visible("#overlay"), "the image as it is is covered")

    # Errors are explained, and none is of the image and itself.
    legend = show(page, "error-dd")
    check("pixels differ" in legend or "pixels are the same" in legend, f"errors are not explained: {legend}")
    check(page.ask("document.querySelector('#shows [value=error-f64]').disabled"), "an image differs from itself")

    # Costs are those of the statistics.
    stats = subprocess.run([GMLVM, "run", "s.gml", "--stats", "-", "--output", "a.ppm", "-q"], cwd=DIRECTORY, capture_output=True, check=True).stdout
    rays = json.loads(stats)["rays"]
    n_rays = rays["primary"] + rays["reflected"] + rays["shadow"]
    legend = show(page, "rays")
    check(f"{n_rays:,} rays" in legend, f"{n_rays:,} rays, but {legend}")
    box = page.page.locator("#picture").bounding_box()
    page.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    check(page.page.inner_text("#here").startswith("here "), "the value under the pointer is not told")
    check("instructions" in show(page, "work"), "instructions are not explained")
    check("boundary" in show(page, "certainty"), "certainty is not explained")
    show(page, "image")


def images_are_compared(page):
    kept = page.pixels()
    check(not page.page.is_visible("#divider"), "there is something to compare with")
    page.page.click("#pin")
    page.page.wait_for_selector("#divider")
    page.type(SCENE.replace("0.25 1.0", "0.75 1.0"))
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")
    page.wait("(document.body.dataset.shown || '').split(' ')[0] === document.body.dataset.run")
    check(page.pixels() != kept and layer(page, "before") == kept, "A is not what was kept")

    def share():
        return float(page.ask("document.getElementById('before').style.getPropertyValue('--share')").rstrip("%"))

    # By the keyboard, and by dragging.
    page.page.focus("#divider")
    page.page.press("#divider", "Home")
    check(share() == 0, f"A is shown to {share()} %")
    page.page.press("#divider", "End")
    check(share() == 100, f"A is shown to {share()} %")
    page.page.press("#divider", "PageDown")
    check(0 < share() < 100, f"A is shown to {share()} %")
    box = page.page.locator("#stack").bounding_box()
    at = box["x"] + box["width"] * share() / 100
    page.page.mouse.move(at, box["y"] + box["height"] / 2)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2, steps=4)
    page.page.mouse.up()
    check(abs(share() - 25) < 3, f"dragged to a quarter, A is shown to {share()} %")
    # The rest of the image can be pointed at as ever.
    page.page.mouse.move(box["x"] + box["width"] * 0.7, box["y"] + box["height"] / 2)
    page.wait("document.getElementById('pixel').textContent.includes('certain')")

    legend = show(page, "a")
    check("pixels differ" in legend, f"nothing differs: {legend}")
    page.page.select_option("#metric", "squared")
    page.wait("(document.body.dataset.shown || '').endsWith('squared')")
    check("its root" in page.page.inner_text("#legend"), "squares have no root")
    page.page.select_option("#metric", "absolute")

    # The last good image can be compared still, while something is wrong.
    page.type(SCENE.replace("0.5 0.5 0.5 point []", "0.5 0.5 radius point []"))
    page.wait("document.getElementById('status').dataset.state === 'bad'")
    check(layer(page, "before") == kept, "A is lost by an error")

    # A method of the chart is compared with what was there before.
    page.type(SCENE)
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")
    page.page.click("#unpin")
    check(not page.page.is_visible("#divider"), "A is still there")
    page.page.click("[role=tab][data-tab=chart]")
    page.run(lambda: page.page.click("#charts button:text-is('grid-4x4')"))
    check(page.ask("document.getElementById('sampling').value === 'grid 4'"), "the method is not chosen")
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")
    page.wait("(document.body.dataset.shown || '').split(' ')[0] === document.body.dataset.run")
    check(page.page.is_visible("#divider"), "there is no A to compare a method with")
    check("pixels differ" in show(page, "a"), "samples make no difference")
    check("double, 1" in page.page.inner_text("#pinned"), page.page.inner_text("#pinned"))

    # Its mark in the drawing does the same, by the keyboard or by a click.
    by_mark = page.page.locator("#charts .marks button[title=grid-2x2]")
    by_mark.focus()
    page.run(lambda: page.page.keyboard.press("Enter"))
    check(page.ask("document.getElementById('sampling').value === 'grid 2'"), "the mark chooses nothing")
    centre = "(element) => { const { left, width, top, height } = element.getBoundingClientRect(); return [left + width / 2, top + height / 2]; }"
    left, top = by_mark.evaluate(centre)
    box = page.page.locator("#charts [data-diagram=sampling] img").bounding_box()
    x, y = (left - box["x"]) / box["width"], (top - box["y"]) / box["height"]
    check(0.1 < x < 0.9 and 0.05 < y < 0.8, f"the mark is at {x:.2f}, {y:.2f}")
    check(page.page.locator("#charts .marks button[title^=naive]").count() == 0, "a method that cannot be chosen has a mark")
    page.run(lambda: page.page.locator("#charts .marks button[title=grid-4x4]").click())
    check(page.ask("document.getElementById('sampling').value === 'grid 4'"), "a click on a mark chooses nothing")
    page.page.click("#unpin")
    page.run(lambda: page.page.select_option("#sampling", "centre"))
    page.page.click("#inspect")
    check(not page.page.is_visible("#tools"), "the tools stay open")
    page.wait("document.getElementById('picture').dataset.run === document.body.dataset.run")


OVERFLOWS = """(() => {
    const isClipped = (element) => {
        for (let at = element; at; at = at.parentElement) {
            if (at !== element && /auto|scroll|hidden/.test(getComputedStyle(at).overflowX)) return true;
        }
        return false; };
    const width = document.documentElement.clientWidth;
    return [...document.body.querySelectorAll("*")].filter((element) => {
        const box = element.getBoundingClientRect();
        if (box.width === 0 || element.closest("#layers")) return false;
        return (box.right > width + 1 || box.left < -1) && !isClipped(element);
    }).map((element) => element.tagName + "#" + element.id + "." + element.className)
        .concat(document.documentElement.scrollWidth > width ? ["the page"] : [])
        .concat(document.documentElement.scrollHeight > innerHeight ? ["the page, below"] : []); })()"""


def screenshots(browser, address):
    SHOTS.mkdir(parents=True, exist_ok=True)
    for width, height in ((1280, 800), (390, 844)):
        for scheme in ("light", "dark"):
            page = Page(browser, address, width, height, scheme)
            page.page.wait_for_selector("#charts [data-diagram=sampling]", state="attached")
            for tab in ("source", "problems", "code", "plan", "stats", "chart"):
                button = page.page.locator(f"[role=tab][data-tab={tab}]")
                if button.is_visible():
                    button.click()
                over = page.ask(OVERFLOWS)
                check(not over, f"at {width}x{height}, {scheme}, {tab}, {over} overflow")
                page.page.screenshot(path=SHOTS / f"{width}-{scheme}-{tab}.png")
            page.page.click("#inspect")
            page.page.wait_for_selector("#shows")
            page.page.click("#pin")
            for what in ("image", "rays", "error-dd", "certainty"):
                show(page, what)
                over = page.ask(OVERFLOWS)
                check(not over, f"at {width}x{height}, {scheme}, comparing {what}, {over} overflow")
                page.page.screenshot(path=SHOTS / f"{width}-{scheme}-compare-{what}.png")
            page.page.close()


complaints, hosts = [], set()
(DIRECTORY / "s.gml").write_text(SCENE)
environment = {name: value for name, value in os.environ.items() if name != "RAYON_NUM_THREADS"}
server = subprocess.Popen(
    [GMLVM, "view", "s.gml", "--edit"], cwd=DIRECTORY, stdout=subprocess.PIPE, text=True, env=environment
)
try:
    address = server.stdout.readline().strip()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = Page(browser, address)
        errors_keep_the_image(page)
        code_is_linked(page)
        pixels_are_explained(page)
        hostile_text_stays_text(page)
        changes_on_disk_arrive(page, SCENE.replace("0.5 made", "0.7 made"))
        changes_on_disk_arrive(page, SCENE)
        edits_are_saved(page)
        images_are_looked_at_closely(page)
        images_are_compared(page)
        page.page.close()
        screenshots(browser, address)
        browser.close()
    check(not complaints, f"the browser complains: {complaints}")
    check(hosts == {"127.0.0.1"}, f"requests go to {hosts}")
finally:
    server.terminate()
    server.wait()
print("all checks passed")
