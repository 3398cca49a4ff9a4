# SPDX-License-Identifier: Apache-2.0
"""Finds links within a static site that lead nowhere."""
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """The anchors of a page, and where it leads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links = {"", "top"}, []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            elif name in ("href", "src") and value is not None:
                self.links.append(value)


def faults(site):
    """A sentence for each link to a file that is not there, or to an anchor that its page does not have."""
    site = pathlib.Path(site).resolve()
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    if not pages:
        return [f"{site} has no pages"]
    found = []
    for path, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            name = path.relative_to(site)
            if not target.is_file() or site not in target.parents:
                found.append(f"{name} leads to {link}, which is not there")
            elif target in pages and urllib.parse.unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{name} leads to {link}, but the page has no such anchor")
    return found


if __name__ == "__main__":
    told = faults(sys.argv[1])
    print("\n".join(told) or "all links lead somewhere")
    sys.exit(1 if told else 0)
