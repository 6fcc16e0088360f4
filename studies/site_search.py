"""Whether the search of the documentation site knows the words that users say.

    make docs
    python studies/site_search.py [WORD ...]    without a word: those of tests/support/said_words.py

Prints the first three pages for each word, and how many words find their page among them. Exit code 1 if one does not.
"""

from __future__ import annotations

import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

from tests.support.said_words import SAID, first_pages

SITE = Path(__file__).parents[1] / "build" / "docs"
CHROMIUM = "/usr/bin/chromium"


def main(words: list[str]) -> int:
    """See the module."""
    if not (SITE / "search.html").is_file():
        raise SystemExit("there is no site yet: make docs")
    known = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page()
        for word in words or SAID:
            found = first_pages(page, SITE, word)
            right = bool(set(found) & set(SAID.get(word, ())))
            known += right
            wanted = "" if right or word not in SAID else f"   not {' or '.join(SAID[word])}"
            print(f"{word:24} {', '.join(found) or 'nothing'}{wanted}", flush=True)
        browser.close()
    if words:
        return 0
    print(f"{known} of {len(SAID)} words find their page among the first three")
    return int(known < len(SAID))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
