"""The site of documents and headers is built without a warning, and has no broken link."""

import html.parser
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Links(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        self.found += [value for name, value in attrs if name in ("href", "src") and value]


@unittest.skipUnless(shutil.which("doxygen"), "doxygen is not installed")
class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.built = subprocess.run([ROOT / "scripts" / "build-docs", cls.folder.name], capture_output=True, text=True, check=False)
        cls.pages = sorted((pathlib.Path(cls.folder.name) / "html").glob("*.html"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_no_warning(self):
        self.assertEqual((self.built.returncode, self.built.stderr), (0, ""))

    def test_every_document_is_a_page(self):
        names = {page.name for page in self.pages}
        for document in (ROOT / "docs").glob("*.md"):
            self.assertIn(f"md_docs_{document.stem}.html", names)
        self.assertIn("classvolccd_1_1Pipeline.html", names)

    def test_links_lead_somewhere(self):
        broken = set()
        for page in self.pages:
            links = Links()
            links.feed(page.read_text(encoding="utf-8"))
            for link in links.found:
                address = urllib.parse.urlsplit(link)
                if address.scheme or not address.path:
                    continue
                target = page.parent / urllib.parse.unquote(address.path)
                if os.path.isabs(address.path) or not target.exists():
                    broken.add(f"{page.name}: {link}")
        self.assertEqual(sorted(broken), [])


if __name__ == "__main__":
    unittest.main()
