# SPDX-License-Identifier: Apache-2.0
"""segctl view writes a page that works in a browser: by clicks, keys and fingers, and by the pixels that it shows."""
import os
import pathlib
import shutil
import struct
import tempfile
import unittest

import numpy

from harness import BAD_INPUT, SUCCESS, segctl
import browser
import pcd

HERE = pathlib.Path(__file__).resolve().parent
# The view is 420 pixels wide in the window of browser.SIZE.
CENTER = (210, 230)
LEFT, RIGHT = (150, 230), (270, 230)  # These show the two plates.


def two_plates(truth=True):
    """A red plate at the left and a blue one at the right, 1 m away and 10 cm deep apart, as an image of 64 x 48."""
    rows = []
    for v in range(48):
        for u in range(64):
            depth = 1.0 if u < 32 else 1.2
            x, y = (u - 31.5) / 60 * depth, (v - 23.5) / 60 * depth
            color = 0xC03020 if u < 32 else 0x2030C0
            rows.append(f"{x:.5f} {y:.5f} {depth} {color}" + (f" {10 if u < 32 else 11}\n" if truth else "\n"))
    fields = ("x y z rgb label", "4 4 4 4 4", "F F F U U", "1 1 1 1 1") if truth else ("x y z rgb", "4 4 4 4", "F F F U",
                                                                                       "1 1 1 1")
    return pcd.header(64 * 48, *fields, width=64, height=48) + "".join(rows).encode()


def write_blocks(path, count):
    """A wavy floor of 20 m with 60 blocks on it as a cloud of about so many points; their exact number."""
    random = numpy.random.default_rng(1)
    side = int(count ** 0.5)
    u, v = numpy.meshgrid(numpy.arange(side), numpy.arange(side))
    x, y = u.ravel() * 20 / side, v.ravel() * 20 / side
    z = 0.05 * numpy.sin(x) * numpy.cos(y)
    for _ in range(60):
        at, size, height = random.uniform(1, 19, 2), random.uniform(0.3, 1.2), random.uniform(0.3, 1.5)
        z[(abs(x - at[0]) < size) & (abs(y - at[1]) < size)] = height
    z += random.normal(0, 0.002, side * side)
    rows = numpy.stack([x, y, z], axis=1).astype("<f4")
    path.write_bytes(pcd.header(side * side, data="binary") + rows.tobytes())
    return side * side


def is_near(color, other, by=3):
    return all(abs(a - b) <= by for a, b in zip(color, other))


class View(browser.PageTest):
    @classmethod
    def setUpClass(cls):
        done = segctl("view", HERE / "missing.pcd", "-o", "-")
        if b"was built without its page" in done.stderr:
            raise unittest.SkipTest("segctl was built without npm: there is no page to test")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-view-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.start_browser()
        cls.plates = cls.folder / "plates.pcd"
        cls.plates.write_bytes(two_plates())

    def write(self, *arguments):
        """The path of the page that segctl view writes."""
        page = self.folder / f"{self.id()}.html"
        done = segctl("view", *arguments, "-o", page)
        self.assertEqual(done.returncode, SUCCESS, done.stderr.decode())
        return page

    def test_shows_segments_and_their_own_colors(self):
        at_left, at_right = ("pixel", *LEFT), ("pixel", *RIGHT)
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"], ["press", "l"], ["press", "Escape"],
                            ["settle"], at_left, at_right, ["press", "2"], ["settle"], at_left, at_right, ["press", "7"],
                            ["settle"], at_left, ["text", "#legend"], ["text", "#regions-value"], ["text", "#heads"])
        segment_left, segment_right, own_left, own_right, error_left, legend, regions, head = [
            answers[k] for k in (4, 5, 8, 9, 12, 13, 14, 15)]
        self.assertFalse(is_near(segment_left, segment_right, 30), "the two plates look alike")
        self.assertTrue(is_near(own_left, (0xC0, 0x30, 0x20)), own_left)
        self.assertTrue(is_near(own_right, (0x20, 0x30, 0xC0)), own_right)
        self.assertTrue(is_near(error_left, (61, 148, 107)), error_left)  # It is right.
        self.assertIn("right: 100.0 %", legend)
        self.assertTrue(regions.startswith("2 of "), regions)
        self.assertIn("3,072 points · 2 segments", head)

    def test_the_keys_are_those_that_do_something(self):
        unlabeled = self.folder / "unlabeled.pcd"
        unlabeled.write_bytes(two_plates(truth=False))
        for expected, *arguments in (((True, False), self.plates), ((False, False), unlabeled),
                                     ((True, True), self.plates, "--compare", "lambda-convex")):
            keys = self.open(self.write(*arguments), ["settle"], ["press", "?"], ["text", "#key-list"])[2]
            self.assertEqual(("Ground truth" in keys and "Errors" in keys, "the other side" in keys), expected)

    def test_sliders_recolor_and_segments_keep_their_colors(self):
        at = ("pixel", *LEFT)
        read = ["run", "[...document.querySelectorAll('#segments li')].map((row) => [row.dataset.node,"
                       " row.querySelector('i').style.background])"]
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"], ["press", "l"], ["settle"], at, read,
                            ["slide", "#regions", 1], ["settle"], at, ["text", "#regions-value"],
                            ["slide", "#regions", 0], ["settle"], ["text", "#regions-value"], read,
                            ["slide", "#threshold", 1], ["settle"], ["text", "#threshold-value"],
                            ["press", ","], ["settle"], ["text", "#regions-value"])
        two, rows_of_two, regions_of_one, regions_of_all, rows_of_all, threshold = [
            answers[k] for k in (3, 4, 8, 11, 12, 15)]
        self.assertTrue(regions_of_one.startswith("1 of "))
        count = regions_of_one.split()[-1]
        self.assertEqual(regions_of_all, f"{count} of {count}")
        self.assertEqual(threshold, "1")
        # The color of each of the two segments is that of its largest part down to a supervoxel.
        self.assertLessEqual({color for _, color in rows_of_two}, {color for _, color in rows_of_all})
        self.assertIn("rgb({}, {}, {})".format(*two), [color for _, color in rows_of_two])

    def test_clicks_choose_include_and_exclude(self):
        facts = ["text", "#chosen-facts"]
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"], ["press", "l"], ["settle"],
                            ["click", *LEFT, None], ["settle"], ["text", "#chosen-title"], facts, ["pixel", *RIGHT],
                            ["click", *RIGHT, "Shift"], ["settle"], facts, ["text", "#chosen-hint"],
                            ["click", *RIGHT, "Alt"], ["settle"], facts, ["text", "#chosen-hint"],
                            ["press", "["], ["text", "#chosen-hint"], ["press", "]"], ["text", "#chosen-hint"],
                            ["press", "Escape"], ["settle"], ["run", "document.getElementById('chosen').hidden"],
                            ["pixel", *RIGHT])
        title, one, dimmed, both, both_hint, without, without_hint = [answers[k] for k in (5, 6, 7, 10, 11, 14, 15)]
        self.assertRegex(title, "^Segment [12]$")
        self.assertIn("1,536 (50.0 %)", one)
        self.assertIn("3,072 (100.0 %)", both)
        self.assertIn("2 included, 0 excluded", both_hint)
        self.assertIn("1,536 (50.0 %)", without)
        self.assertIn("1 included, 1 excluded", without_hint)
        self.assertLess(sum(dimmed), sum(answers[-1]), "what is not chosen is not dimmed")
        smaller, larger = answers[17], answers[19]
        self.assertNotEqual(smaller, without_hint)
        self.assertEqual(larger, without_hint)
        self.assertIs(answers[-2], True)

    def test_hover_tells_of_the_segment_and_the_tree_can_be_clicked(self):
        box = "document.getElementById('dendrogram').getBoundingClientRect()"
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"], ["move", *LEFT], ["settle"],
                            ["text", "#tip"], ["run", f"[{box}.x, {box}.y]"], ["move", 20, 450], ["settle"],
                            ["run", "document.getElementById('tip').hidden"])
        self.assertRegex(answers[3], r"^Segment [12] · 1,536 points · stability [01]\.\d+$")
        self.assertIs(answers[-1], True)
        x, y = answers[4]
        # The end of the tree's root.
        told = self.open(self.write(self.plates, "--regions", "2"), ["settle"], ["click", x + 308, y + 140, None],
                         ["settle"], ["text", "#chosen-facts"], ["wheel", x + 150, y + 150, -400],
                         ["drag", x + 150, y + 100, x + 150, y + 60], ["settle"])
        self.assertIn("3,072 (100.0 %)", told[3])

    def test_draws_boxes_edges_and_normals(self):
        count = ["run", "(() => { const view = document.getElementById('view'); const copy = document.createElement('canvas');"
                        "[copy.width, copy.height] = [view.width, view.height]; const pen = copy.getContext('2d');"
                        "pen.drawImage(view, 0, 0); const bytes = pen.getImageData(0, 0, copy.width, copy.height).data;"
                        "let sum = 0; for (let i = 0; i < bytes.length; ++i) sum = (sum * 31 + bytes[i]) % 1000000007;"
                        "return sum; })()"]
        pictures = [count]
        for key in ("b", "b", "g", "g", "4", "5", "3", "6", "1", "ArrowLeft", "h"):
            pictures += [["press", key], ["settle"], count]
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"], *pictures)
        sums = [answers[1], *answers[4::3]]
        first, boxes, same, edges, again, *others = sums
        self.assertNotEqual(boxes, first)
        self.assertEqual(same, first)
        self.assertNotEqual(edges, first)
        self.assertEqual(again, first)
        self.assertEqual(len({first, *others}), 6, "two ways to color, or two views, look alike")
        self.assertEqual([others[4], others[6]], [first, first], "the keys 1 and h do not lead back")

    def test_two_methods_side_by_side(self):
        answers = self.open(self.write(self.plates, "--compare", "lambda-convex"), ["settle"], ["text", "#heads"],
                            ["text", "#sides"], ["click", 315, 230, None], ["settle"],
                            ["run", "document.querySelector('#sides [aria-selected=true]').textContent"],
                            ["press", "x"], ["run", "document.querySelector('#sides [aria-selected=true]').textContent"])
        self.assertEqual(answers[1].count("plates.pcd"), 2)
        self.assertIn("lambda-convex", answers[1])
        self.assertEqual(answers[5], "B: lambda-convex")
        self.assertEqual(answers[7], "A: border")

    def test_what_is_the_same_on_both_sides_has_the_same_color(self):
        # The panes are one above the other, 230 pixels high each.
        row = ("((y) => { const copy = document.createElement('canvas'); copy.width = 420; copy.height = 1; const pen ="
               " copy.getContext('2d'); pen.drawImage(document.getElementById('view'), 0, -y); const bytes ="
               " pen.getImageData(0, 0, 420, 1).data; return Array.from({length: 420}, (_, x) =>"
               " [...bytes.slice(4 * x, 4 * x + 3)].join()); })")
        answers = self.open(self.write(self.plates, "--regions", "2", "--compare", "equalization"), ["settle"],
                            ["press", "l"], ["settle"], ["run", f"{row}(150)"], ["run", f"{row}(380)"])
        self.assertEqual(answers[3], answers[4])
        self.assertEqual(len(set(answers[3])), 3)  # the ground and two plates

    def test_two_results_of_one_cloud_share_it(self):
        results = [self.folder / name for name in ("first.segres", "second.segres")]
        for result, regions in zip(results, ("2", "5")):
            self.assertEqual(segctl("segment", self.plates, "--local", "-q", "--regions", regions, "--result",
                                    result).returncode, SUCCESS)
        page = self.write(*results, "--cloud", self.plates)
        self.assertEqual(page.read_text().count('"placement"'), 1)
        answers = self.open(page, ["settle"], ["text", "#heads"])
        self.assertIn("first.segresborder · 3,072 points · 2 segments", answers[1])
        self.assertIn("second.segresborder · 3,072 points · 5 segments", answers[1])

    def test_saves_a_picture_and_the_labels_of_the_current_cut(self):
        downloads = self.folder / self.id()
        answers = self.open(self.write(self.plates, "--regions", "9"), ["settle"], ["download", "#save-picture"],
                            ["slide", "#regions", 1], ["press", ","], ["settle"], ["download", "#save-ply"],
                            ["text", "#regions-value"])
        self.assertTrue((downloads / answers[1]).read_bytes().startswith(b"\x89PNG"))
        self.assertTrue(answers[-1].startswith("2 of "))
        labels = self.folder / "cut.ply"
        result = self.folder / "nine.segres"
        self.assertEqual(segctl("segment", self.plates, "--local", "-q", "--regions", "2", "-o", labels,
                                "--encoding", "ascii").returncode, SUCCESS)
        expected = [row.split() for row in labels.read_text().split("end_header\n")[1].splitlines()]
        content = (downloads / answers[5]).read_bytes()
        head, body = content.split(b"end_header\n", 1)
        self.assertIn(b"element vertex 3072\n", head)
        rows = list(struct.iter_unpack("<3f3BI", body))
        self.assertEqual([row[6] for row in rows], [int(row[-1]) for row in expected])
        self.assertEqual([struct.pack("<3f", *row[:3]) for row in rows],
                         [struct.pack("<3f", *map(float, row[:3])) for row in expected])

    def test_a_phone_is_wide_enough_and_fingers_work(self):
        answers = self.open(self.write(self.plates, "--regions", "2"), ["settle"],
                            ["run", "[document.documentElement.scrollWidth, innerWidth,"
                                    " document.getElementById('stage').clientHeight]"],
                            ["press_button", "[data-mode=include]"], ["tap", 160, 220], ["settle"],
                            ["text", "#chosen-facts"], size=(390, 844))
        width, window, height = answers[1]
        self.assertLessEqual(width, window)
        self.assertGreater(height, 300)
        self.assertIn("1,536 (50.0 %)", answers[5])

    def test_names_are_text_and_nothing_else(self):
        """A malicious name of a file adds no element to the page, and runs nothing."""
        name = "<img src=x onerror=alert(1)><script>alert(2)<!--.pcd"
        hostile = self.folder / name
        hostile.write_bytes(two_plates(truth=False))
        usual = self.write(self.plates).read_text()
        page = self.write(hostile)
        text = page.read_text()
        self.assertNotIn("<img", text)
        self.assertEqual(text.count("<script"), usual.count("<script") - 1)  # It has no array of labels.
        answers = self.open(page, ["settle"], ["text", "#heads b"],
                            ["run", "document.querySelectorAll('img, iframe, object, embed, link, base').length"],
                            ["run", "document.title"])
        self.assertEqual(answers[1:], [name, 0, f"{name} - segserve"])

    def test_a_script_that_got_in_would_not_run(self):
        inject = ("(() => { const script = document.createElement('script'); script.textContent = 'window.ran = true';"
                  " document.body.append(script); return window.ran ?? false; })()")
        load = "fetch('https://example.com/').then(() => 'loaded', () => 'refused')"
        answers = self.open(self.write(self.plates), ["settle"], ["run", inject], ["run", load],
                            faults=["Content Security Policy"] * 3)
        self.assertEqual(answers[1:], [False, "refused"])

    def test_a_large_cloud_stays_usable(self):
        """Prints how long its page takes. PAGE_POINTS is the number of points."""
        wanted = int(os.environ.get("PAGE_POINTS", "300000"))
        cloud = self.folder / "large.pcd"
        points = write_blocks(cloud, wanted)
        page = self.write(cloud, "--voxel-resolution", "0.03")
        slide = ("(() => { const slider = document.getElementById('regions'); slider.value = 0.4; const start ="
                 " performance.now(); slider.dispatchEvent(new Event('input')); return performance.now() - start; })()")
        turn = ("new Promise((done) => { const times = []; const view = document.getElementById('view'); const step = (now)"
                " => { times.push(now); if (times.length > 20) return done((times.at(-1) - times[0]) / 20);"
                " document.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'})); requestAnimationFrame(step); };"
                " requestAnimationFrame(step); })")
        answers = self.open(page, ["settle"], ["run", "performance.memory.usedJSHeapSize / 1e6"], ["run", slide],
                            ["settle"], ["run", turn], ["settle"])
        status, memory, slider_ms, frame_ms = answers[0], answers[1], answers[2], answers[4]
        print(f"\n{page.stat().st_size / 1e6:.0f} MB for {points} points; {status}; {memory:.0f} MB of"
              f" memory; the slider takes {slider_ms:.0f} ms, a frame in motion {frame_ms:.0f} ms")
        self.assertTrue(status.startswith(f"{points:,} points"), status)
        self.assertLess(memory, 100 + 150e-6 * points)

    def test_an_empty_cloud_is_shown_as_such(self):
        empty = self.folder / "empty.pcd"
        empty.write_bytes(pcd.ascii_file([("nan", "nan", "nan")] * 3))
        answers = self.open(self.write(empty, "--view", "world"), ["settle"], ["text", "#heads"], ["press", "b"],
                            ["press", "g"], ["click", *CENTER, None], ["settle"], ["text", "#regions-value"])
        self.assertIn("0 points · 0 segments", answers[1])
        self.assertEqual(answers[-1], "0 of 0")

    def test_refuses_what_it_cannot_show(self):
        result = self.folder / "alone.segres"
        segctl("segment", self.plates, "--local", "-q", "--result", result)
        other = self.folder / "other.pcd"
        other.write_bytes(pcd.ascii_file([(0, 0, 1)] * 9))
        for arguments, reason in (((result,), "needs --cloud"), ((result, "--cloud", other), "it is another cloud"),
                                  ((self.plates, "--compare", "magic"), "'magic' is not a method"),
                                  ((self.plates, self.plates, "--compare", "border"), "side by side already")):
            with self.subTest(reason):
                done = segctl("view", *arguments, "-o", self.folder / "no.html")
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn(reason, done.stderr.decode())
                self.assertFalse((self.folder / "no.html").exists())


if __name__ == "__main__":
    unittest.main()
