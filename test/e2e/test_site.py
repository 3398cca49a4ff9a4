# SPDX-License-Identifier: Apache-2.0
"""The static site of the documents is built (docs/site/build), and no link in it leads nowhere."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(REPOSITORY / "docs/site"))

import check_links  # noqa: E402

TOOLS = ("sphinx-build", "doxygen", "protoc")
JAVASCRIPT = (("js/index", "Segments a cloud. One that is too large for a message goes by a stream, in chunks."),
              ("js/web", "Calls one or more servers over their web entrance.")) if shutil.which("npm") else ()
PACKAGES = ("/usr/lib/python3/dist-packages/furo", "/usr/lib/python3/dist-packages/myst_parser")


def build(folder, **environment):
    return subprocess.run(["/usr/bin/python3", "-B", REPOSITORY / "docs/site/build.py", folder], capture_output=True, text=True,
                          timeout=1500, env=os.environ | environment)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        missing = [tool for tool in TOOLS if shutil.which(tool) is None]
        missing += [package for package in PACKAGES if not os.path.exists(package)]
        if missing:
            raise unittest.SkipTest(f"there is no {', '.join(missing)} to build the site with: deploy/install-packages site")
        cls.work = pathlib.Path(tempfile.mkdtemp(prefix="segserve-site-"))
        cls.addClassCleanup(shutil.rmtree, cls.work)
        cls.site = cls.work / "site"
        cls.built = build(cls.site)

    def text(self, page):
        return (self.site / page).read_text()

    def test_it_is_built_without_a_warning(self):
        self.assertEqual((self.built.returncode, self.built.stderr), (0, ""))

    def test_every_link_leads_somewhere(self):
        self.assertEqual(check_links.faults(self.site), [])
        self.assertGreater(len(list(self.site.rglob("*.html"))), 100)

    def test_every_figure_is_a_picture_that_a_command_has_made(self):
        for page in ("how_it_works", "limits", "tracking"):
            shown = re.findall(r'src="\.\./(_images/[\w.]+)"', self.text(f"docs/{page}.html"))
            self.assertGreater(len(shown), 3)
            for name in shown:
                self.assertTrue((self.site / name).read_bytes().startswith(b"\x89PNG"), name)

    def test_the_reference_has_comments_docstrings_and_help_texts(self):
        for page, said in (("api/segmentation_service", "Segments one cloud. This is the call for small clients in any language."),
                           ("cpp/segserve/segment", "A segmented cloud of N points and m supervoxels."),
                           ("python/client", "Segments a cloud. One that is too large for a message goes by a stream, in chunks."),
                           *JAVASCRIPT, ("segctl", "--drop-unlabeled"), ("segserve", "--drain-delay")):
            self.assertTrue(said in self.text(f"reference/{page}.html"), f"{page} does not say: {said}")

    def test_pages_need_no_network(self):
        for path in self.site.rglob("*.html"):
            loaded = re.findall(r'<(?:script|img|iframe)\b[^>]*\bsrc="(https?:[^"]*)"|<link\b[^>]*\bhref="(https?:[^"]*)"',
                                path.read_text())
            self.assertEqual(loaded, [], path)

    def test_without_the_program_it_says_what_is_missing(self):
        told = build(self.work / "other", SEGCTL="/nowhere/segctl")
        self.assertEqual(told.returncode, 1)
        self.assertRegex(told.stderr, r"\Asite: /nowhere/segctl is not there: .*\n\Z")


class Links(unittest.TestCase):
    """The check would notice a link that leads nowhere."""

    def faults(self, **pages):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in pages.items():
                (pathlib.Path(folder) / f"{name}.html").write_text(text)
            return check_links.faults(folder)

    def test_files_and_anchors_are_looked_for(self):
        self.assertEqual(self.faults(a='<a href="b.html#x">', b='<h1 id="x">'), [])
        self.assertEqual(self.faults(a='<a href="https://example.org/none"><a href="#">'), [])
        self.assertEqual(self.faults(a='<a href="c.html">'), ["a.html leads to c.html, which is not there"])
        self.assertEqual(self.faults(a='<a href="#y">'), ["a.html leads to #y, but the page has no such anchor"])
        self.assertEqual(self.faults(a='<img src="../a.html">'), ["a.html leads to ../a.html, which is not there"])

    def test_a_folder_without_pages_is_no_site(self):
        self.assertEqual(len(self.faults()), 1)


if __name__ == "__main__":
    unittest.main()
