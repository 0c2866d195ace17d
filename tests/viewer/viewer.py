#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A page in a real browser: viewer.py PAGE [SCREENSHOTS]. Checks state and pixels, and holds what the viewer computes
against what this program computes from the numbers in the page. Exits 77 (skipped) without Chromium or without the page."""
import json
import os
import sys
import tempfile

page, shots = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None
if not os.path.exists(page):
    print(f"skipped: there is no page {page} (pipeline_smoke writes it)")
    sys.exit(77)
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import numpy  # noqa: E402

from browser import CHROMIUM, Browser, decode_png  # noqa: E402
from page_data import PageData  # noqa: E402

if not CHROMIUM:
    print("skipped: Debian's chromium is not installed (apt-get install chromium)")
    sys.exit(77)
failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def shot(browser, name):
    browser.settle()
    return browser.screenshot(shots and f"{shots}/{name}.png")


def picture(image):
    """The part of a screenshot that shows bodies: without panel, timeline and what lies over the picture's edges."""
    return image[top:690, 0:970].astype(int)


top = 66  # above it stand title and names of the methods
background = numpy.array([243, 242, 239])


def drawn(image):
    return numpy.abs(picture(image) - background).max(axis=2) > 12


def of_colour(image, colour, within=3):
    wanted = numpy.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)])
    return int((numpy.abs(picture(image) - wanted).max(axis=2) <= within).sum())


def hidden_but(*shown):
    """Script: these layers alone, opaque."""
    return "".join(f"v.setLayer('{layer}', {{shown: {json.dumps(layer in shown)}, opacity: 1}});"
                   for layer in ("skin", "fat", "muscle_wrap", "muscles", "bone_wrap", "bones"))


cuts = {"skin": "#c99c84", "fat": "#ecd591", "muscle_wrap": "#b4574c", "muscles": "#8f3029", "bone_wrap": "#c9a98a", "bones": "#f4ecd6"}
data = PageData(page)
head = data.head
last = head["num_frames"] - 1
url = "file://" + os.path.abspath(page)


def loads_and_plays(b):
    b.open(url)
    b.run("NdgViewer.get().finePixelRatio = 1")  # software draws these pictures
    state = b.run("NdgViewer.state()")
    times = state["times"]
    print(f"      first picture after {times['firstPicture'] / 1000:.2f} s, all {head['num_frames']} frames after "
          f"{times['complete'] / 1000:.2f} s, {os.path.getsize(page) / 1e6:.1f} MB")
    check(b.messages == [] and state["problems"] == [], f"the page loads from a file and says nothing: {b.messages}")
    check(all(r.startswith(("file:", "data:", "blob:")) for r in b.requests), "it asks no network for anything")
    check(state["numLoaded"] == head["num_frames"], "all frames arrive")
    b.run(f"v = NdgViewer.get(); {hidden_but('skin')} 1")
    image = shot(b, "front")
    shown = drawn(image)
    check(shown[:, :485].mean() > 0.04 and shown[:, 485:].mean() > 0.04, "both methods are seen")
    check(abs(shown[:, :485].sum() / shown[:, 485:].sum() - 1) < 0.2, "in the same size")

    b.click_on("#play")
    b.wait("NdgViewer.state().playing && NdgViewer.state().frame >= 2")
    b.click_on("#play")
    frame = b.run("NdgViewer.state().frame")
    b.run("new Promise((resolve) => setTimeout(resolve, 400))")
    check(b.run("NdgViewer.state().frame") == frame and not b.run("NdgViewer.state().playing"), "it plays and pauses")
    box = b.run("(() => { const r = document.querySelector('#scrubber').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()")
    b.click(box[0] + box[2] / 3, box[1] + box[3] / 2)
    check(abs(b.run("NdgViewer.state().frame") - last / 3) <= max(1, 0.02 * last), "the scrubber goes to where it is clicked")
    check(box[2] > 800, "and is as wide as the window allows")
    bent = shot(b, "bent")
    check((drawn(bent) != shown).mean() > 0.02, "where the body has another pose")
    b.click_on("#on")
    b.click_on("#on")
    b.click_on("#back")
    check(b.run("NdgViewer.state().frame") == round(b.run("Number(document.querySelector('#scrubber').value)")), "single frames are stepped")
    seconds = b.run("""(() => {
      const v = NdgViewer.get(), gl = v.stage.renderer.getContext(), pixel = new Uint8Array(4), start = performance.now();
      for (let f = 0; f < 10; ++f) { v.frame = f % v.numFrames; v.render(); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); }
      return (performance.now() - start) / 10000; })()""")
    name = b.run("(() => { const gl = NdgViewer.get().stage.renderer.getContext(); return gl.getParameter(gl.RENDERER); })()")
    print(f"      {1 / seconds:.1f} pictures a second of both bodies ({name})")


def numbers_are_right(b):
    b.run(f"v = NdgViewer.get(), v.play(false), v.setColour('tissue'), v.setMethods(0, 1), v.setFrame({last // 3})")
    b.settle()
    f = last // 3
    for slot in range(2):
        own = numpy.array(b.run(f"Array.from(v.shapeOf({slot}).points)")).reshape(-1, 4)[:, :3]
        check(numpy.abs(own - data.points(f, slot)).max() < 1e-6, f"points of {head['methods'][slot]} are those of the page")
    for layer in ("bone", "muscle"):
        own = numpy.array(b.run(f"Array.from(v.anatomy.{layer}s.evaluate(v.shapeOf(1)))")).reshape(-1, 3)
        check(numpy.abs(own - data.anatomy(layer, f, 1)).max() < 1e-5, f"every {layer} is where its carriers put it")
    for layer, name in ((0, "muscle_wrap"), (1, "fat")):
        now, rest = b.run(f"v.volumeOf('{name}', 1)")
        check(abs(now / data.layer_volume(layer, data.points(f, 1)) - 1) < 1e-4 and abs(rest / data.layer_volume(layer, data.rest()) - 1) < 1e-4,
              f"the volume of layer {layer} is {1e6 * now:.0f} cm3")
    b.run("v.setColour('distance')")
    b.settle()
    own = numpy.array(b.run("Array.from(v.shapeOf(1).points)")).reshape(-1, 4)[:, 3]
    true = numpy.linalg.norm(data.points(f, 1) - data.points(f, 0), axis=1)
    check(true.max() > 1e-3 and numpy.abs(own - true).max() < 1e-6, f"distances between the methods reach {1000 * true.max():.1f} mm")
    check(b.run("document.querySelector('#bar').innerText").endswith("10 mm"), "the colour bar has a unit")
    b.run("v.setColour('volume')")
    b.settle()
    own = numpy.array(b.run("Array.from(v.shapeOf(1).points)")).reshape(-1, 4)[head["num_common"] + head["num_wrap"]:, 3][:head["num_wrap"]]
    check(numpy.abs(own - data.skin_volume_change(data.points(f, 1))).max() < 1e-3, f"volume changes at the skin go from {100 * own.min():.0f} to {100 * own.max():.0f} %")
    b.run("v.setColour('stretch')")
    b.settle()
    stretch = numpy.array(b.run("Array.from(v.shapeOf(1).points)")).reshape(-1, 4)[head["num_common"]:, 3][:2 * head["num_wrap"]]
    check(stretch.min() > -0.3 and stretch.max() > 0.05, f"largest stretches go to {100 * stretch.max():.0f} %")
    rest = b.run("(v.fields.apply('stretch', v.rest), Array.from(v.rest.points).filter((_, i) => i % 4 === 3 && _ < 1e8))")
    check(len(rest) == 3 * head["num_wrap"] and max(map(abs, rest)) < 1e-5, "and at rest nothing is stretched")
    b.run("v.setColour('tissue')")


def layers_and_parts(b):
    b.run(f"v.setMethods(0, NaN), v.setFrame(0), v.lookFrom('front'), {hidden_but('skin')} 1")
    skin = shot(b, "skin")
    b.click_on("#layer-skin")
    check(b.run("!NdgViewer.state().layers.skin.shown") and not drawn(shot(b, "nothing")).any(), "without any layer nothing is drawn")
    b.click_on("#layer-muscles")
    muscles = shot(b, "muscles")
    red = picture(muscles)[drawn(muscles)]
    check(drawn(muscles).sum() > 5000 and (red[:, 0] > 1.5 * red[:, 1]).mean() > 0.8, "muscles are red")
    check(drawn(muscles).sum() < drawn(skin).sum(), "and lie inside of the skin")
    b.run(f"{hidden_but('skin')} v.setLayer('skin', {{opacity: 0.3}}); v.setLayer('bones', {{shown: true}}); 1")
    through = shot(b, "through")
    check((numpy.abs(picture(through) - picture(skin)).max(axis=2) > 25).sum() > 3000, "bones are seen through a translucent skin")

    b.type("#search", "vastus lateralis")
    names = b.run("[...document.querySelectorAll('#parts li')].map((e) => e.dataset.part)")
    check(len(names) >= 2 and all("vastus lateralis" in n.lower() for n in names), f"a search finds {names}")
    fma = next(p["fma"] for p in head["muscles"] if "vastus lateralis" in p["name"].lower())
    b.type("#search", f"FMA {fma}")
    found = b.run("[...document.querySelectorAll('#parts li')].map((e) => e.dataset.part)")
    check(len(found) == 1 and found[0] in names, f"FMA {fma} is {found}")
    b.key("Enter", code="Enter")
    check(b.run("NdgViewer.state().selected") == found[0], "Enter selects it")
    b.settle()
    b.click_on("#isolate")
    alone = drawn(shot(b, "isolated"))
    rows, columns = numpy.where(alone)
    part = next(i for i, p in enumerate(head["muscles"]) if p["name"] == found[0])
    begin, end = head["muscles"][part]["vertices"]
    vertices = data.anatomy("muscle", 0, 0)[begin:end]
    places = numpy.array(b.run(f"{json.dumps(vertices.tolist())}.map((p) => v.project(p, 0))"))
    low, high = places.min(axis=0), places.max(axis=0)
    check(alone.any() and numpy.abs(numpy.array([columns.min(), rows.min() + top]) - low).max() < 3 and
          numpy.abs(numpy.array([columns.max(), rows.max() + top]) - high).max() < 3, "isolated, it alone is drawn, where its vertices are")
    b.click_on("#ghost")
    ghosts = drawn(shot(b, "ghosts"))
    check(b.run("NdgViewer.state().others") == "ghost" and ghosts.sum() > 5 * alone.sum(), "the rest is ghosted around it")
    b.click_on("#hide")
    check(b.run("NdgViewer.state().selected") is None and b.run("NdgViewer.state().hidden.length") == 1, "it is hidden")
    b.click_on("#show-all")
    check(b.run("NdgViewer.state().hidden.length") == 0, "and shown again")
    b.run(f"{hidden_but('muscles')} 1")
    b.settle()
    x, y = places[numpy.argsort(numpy.linalg.norm(places - places.mean(axis=0), axis=1))[0]]
    picked = b.run(f"v.pickAt({x}, {y})")
    b.click(x, y)
    selected = b.run("NdgViewer.state().selected")
    check(picked and selected == head["muscles"][picked["part"]]["name"], f"a click on the picture selects {selected}")
    b.key("Escape", code="Escape")
    check(b.run("NdgViewer.state().selected") is None, "Escape selects nothing")


def sections(b):
    b.run(f"v.setFrame(0), {hidden_but('skin')} v.setCut({{kind: 'side', offset: 0.1, flipped: false}}), 1")
    origin = head["origins"][0]
    b.run(f"v.controls.target.set({origin[0]}, 0.9, {origin[2]}), v.camera.position.set({origin[0]} + 4, 0.9, {origin[2]}), v.changed()")
    cut = shot(b, "section-skin")
    pixel = 2 * (4 - 0.1) * numpy.tan(numpy.radians(15)) / b.run("v.height")
    seen, true = of_colour(cut, cuts["skin"]) * pixel ** 2, data.skin_section_area(0, 0, 0, origin[0] + 0.1)
    check(true > 0.05 and abs(seen / true - 1) < 0.03, f"the section through the skin is filled: {1e4 * seen:.0f} of {1e4 * true:.0f} cm2")
    b.run(f"{hidden_but(*cuts)} v.setFrame({last // 4}), 1")
    tissues = shot(b, "section")
    areas = {layer: of_colour(tissues, colour) for layer, colour in cuts.items()}
    check(min(areas[layer] for layer in ("fat", "muscle_wrap", "muscles", "bone_wrap", "bones")) > 60, f"every tissue has its colour in the cut: {areas}")
    b.run("v.setCut({kind: 'none'})")
    check(sum(of_colour(shot(b, "whole"), cuts[layer], 0) for layer in ("fat", "bones")) < 60, "and without a section there is none")


def measures(b):
    b.run(f"v.setFrame(0), v.setMethods(0, NaN), v.lookFrom('front'), {hidden_but('skin')} 1")
    b.settle()
    points = data.points(0, 0)
    skin = points[data.tables["skin_points"]]
    middle = numpy.array(head["origins"][0])
    chest, knee = (skin[numpy.argmin(numpy.linalg.norm(skin - (middle + at), axis=1))] for at in ([0.05, 0.35, 0.2], [0.1, -0.4, 0.2]))
    b.click_on("#measure")
    for place in b.run(f"{json.dumps([chest.tolist(), knee.tolist()])}.map((p) => v.project(p, 0))"):
        b.click(*place)
    true = numpy.linalg.norm(chest - knee)
    check(abs(b.run("NdgViewer.state().distance") - true) < 0.006, f"between two clicked points lie {1000 * true:.0f} mm")
    shot(b, "measured")
    b.run(f"v.setFrame({last // 3})")
    b.settle()
    moved = b.run("v.distance()")
    check(abs(moved - true) > 0.01 and b.run("document.querySelector('#distance').textContent").startswith(f"{1000 * moved:.1f} mm"),
          f"in another frame they are {1000 * moved:.0f} mm")
    b.key("Escape", code="Escape")
    png = bytes(b.run("v.png().then((blob) => blob.arrayBuffer()).then((buffer) => Array.from(new Uint8Array(buffer)))"))
    saved = decode_png(png)
    check(saved.shape[1] == b.run("v.width") and (numpy.abs(saved.astype(int) - background).max(axis=2) > 12).mean() > 0.03,
          f"the picture is saved as PNG, {saved.shape[1]} x {saved.shape[0]}")


def links(b):
    name = next(p["name"] for p in head["bones"] if "emur" in p["name"])
    b.run(f"v.marks = [], v.setFrame({last // 2}), v.lookFrom('left'), {hidden_but('muscles', 'bones')} v.setLayer('muscles', {{opacity: 0.4}}), "
          f"v.setCut({{kind: 'depth', offset: 0.02, flipped: true}}), v.select('bones', v.partOf({json.dumps(name)}).index), v.setMethods(1, NaN)")
    image = shot(b, "linked")
    b.wait(f"location.hash.includes('frame={last // 2}&') && location.hash.includes('depth')")
    link, before = b.run("location.href"), b.run("NdgViewer.state()")
    b.call("Page.navigate", url="about:blank")
    b.open(link)
    b.run("v = NdgViewer.get(), v.finePixelRatio = 1")
    after = b.run("NdgViewer.state()")
    same = [key for key in ("frame", "methods", "layers", "colour", "selected", "others", "hidden") if before[key] == after[key]]
    check(len(same) == 7 and before["cut"]["kind"] == after["cut"]["kind"] and after["cut"]["flipped"], f"a link brings back {same} and the section")
    again = shot(b, "linked-again")
    check(numpy.abs(picture(image) - picture(again)).mean() < 0.5, "and the same picture")
    b.call("Page.navigate", url="about:blank")
    b.open(url + "#frame=1e9&camera=x&layers=skin:7,:,zz:0.5&cut=;,&part=nobody&methods=9,-1&colour=%E0%A4%A&range=-3")
    check(b.run("NdgViewer.state().frame") == last and b.messages == [], f"a link of nonsense does no harm: {b.messages}")
    b.run("v = NdgViewer.get(), v.finePixelRatio = 1")


def for_everybody(b):
    b.run("document.activeElement.blur(), v.setFrame(0), 1")
    b.key("ArrowRight", code="ArrowRight")
    b.key("ArrowRight", code="ArrowRight", modifiers=8)
    check(b.run("NdgViewer.state().frame") == min(last, 11), "arrow keys step through frames, with shift ten at once")
    b.key(" ", code="Space")
    b.wait("NdgViewer.state().playing")
    b.key(" ", code="Space")
    skin = b.run("NdgViewer.state().layers.skin.shown")
    b.key("1")
    check(not b.run("NdgViewer.state().playing") and b.run("NdgViewer.state().layers.skin.shown") != skin, "space plays, digits toggle layers")
    b.key("/")
    check(b.run("document.activeElement.id") == "search", "/ goes to the search")
    nameless = b.run("""[...document.querySelectorAll('button, input, select, canvas, [role=listbox]')].filter((e) =>
      !(e.getAttribute('aria-label') || e.labels?.length)).map((e) => e.outerHTML)""")
    check(nameless == [], f"every control has a name: {nameless}")
    faint = b.run("""(() => {
      const parse = (c) => c.match(/[\\d.]+/g).map(Number);
      const lightness = (c) => c.slice(0, 3).map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
        .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
      const below = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if ((c[3] ?? 1) > 0.5) return c; } return [243, 242, 239]; };
      return [...document.querySelectorAll('body *')].filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()) && e.checkVisibility())
        .map((e) => { const [a, b] = [parse(getComputedStyle(e).color), below(e)].map(lightness);
          return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.slice(0, 30)]; })
        .filter(([contrast]) => contrast < 4.5); })()""")
    check(faint == [], f"all text has a contrast of 4.5 or more (WCAG AA): {faint}")


def elsewhere(folder):
    with open(page) as file:
        text = file.read()
    frame = os.path.join(folder, "frame.html")
    with open(frame, "w") as file:
        file.write(f'<!DOCTYPE html><body style="margin:0"><iframe src="{url}" sandbox="allow-scripts" style="width:640px;height:500px;border:0"></iframe>')
    with Browser(800, 600) as b:
        b.call("Page.navigate", url="file://" + frame)
        for _ in range(60):
            b.run("new Promise((resolve) => setTimeout(resolve, 1000))")
            image = b.screenshot(shots and f"{shots}/frame.png")
            shown = (numpy.abs(image[50:440, 20:620].astype(int) - background).max(axis=2) > 12).mean()
            if 0.03 < shown < 0.9:
                break
        check(0.03 < shown < 0.9 and b.messages == [], f"inside of a frame it shows the body: {b.messages}")
    with Browser(390, 844, 2, True) as b:
        b.open(url)
        b.run("NdgViewer.get().finePixelRatio = 1")
        b.settle()
        image = b.screenshot(shots and f"{shots}/phone.png")
        check(b.run("document.documentElement.scrollWidth") <= 390 and b.run("document.querySelector('#panel').offsetHeight") == 0,
              "on a phone nothing is wider than the screen, and the controls are folded")
        half = image[100:1300].astype(int)
        check((numpy.abs(half - background).max(axis=2) > 12).mean() > 0.05, "the bodies are seen")
        b.click_on("#menu")
        b.settle()
        b.screenshot(shots and f"{shots}/phone-controls.png")
        check(b.run("document.querySelector('#panel').offsetHeight") > 250 and b.run("document.documentElement.scrollWidth") <= 390, "the controls unfold")
        small = b.run("[...document.querySelectorAll('button, select')].filter((e) => e.checkVisibility() && e.offsetHeight < 36).map((e) => e.outerHTML)")
        check(small == [], f"and can be hit with a finger: {small}")
    damaged = os.path.join(folder, "damaged.html")
    lines = text.split("\n")
    at = next(i for i, line in enumerate(lines) if 'name:"method_0",frame:1,' in line)
    with open(damaged, "w") as file:
        file.write("\n".join(lines[:at] + lines[at + 1:]))
    with Browser() as b:
        b.open("file://" + damaged)
        check("damaged" in b.run("document.querySelector('#problem').textContent"), "a page that lacks frames says so")


with tempfile.TemporaryDirectory() as scratch:
    with Browser() as browser:
        for part in (loads_and_plays, numbers_are_right, layers_and_parts, sections, measures, links, for_everybody):
            part(browser)
        check(browser.messages == [], f"in all of this the console stays empty: {browser.messages}")
    elsewhere(scratch)
print(f"{len(failures)} failures")
sys.exit(1 if failures else 0)
