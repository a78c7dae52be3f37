"""The page of figures says "The survey says" with nothing but the claims of meander.figures.claims.

claims_test.py MEANDER
"""
import html
import os
import re
import subprocess
import sys
import tempfile

try:
    import numpy  # noqa: F401
except ImportError:
    sys.exit(77)

from meander.figures import claims, registry

SAID = re.compile(r"<p><b>The survey says\.</b> (.*?)</p>")


def main(program):
    assert sorted(claims.CAPTIONS) == sorted(registry.names()), "captions and figures differ"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "figures", "-o", folder, "--quick", "--only", "1,2,4-placement"], check=True,
                       stdout=subprocess.DEVNULL)
        with open(os.path.join(folder, "index.html"), encoding="utf-8") as file:
            page = file.read()
    for name in ("1", "2", "4-placement"):
        assert html.escape(claims.CAPTIONS[name].title) in page, name
    said = [html.unescape(text) for text in SAID.findall(page)]
    assert len(said) == 2, said  # figure 1 claims nothing
    known = {caption.claim for caption in claims.CAPTIONS.values()}
    for text in said:
        assert text in known, text
    assert page.count("<b>The survey says") == len(said)
    # No module writes it by itself: the one place is FigureSet.measured, which takes the claim of the figure.
    folder = os.path.dirname(claims.__file__)
    places = [name for name in os.listdir(folder) if name.endswith(".py")
              for line in open(os.path.join(folder, name), encoding="utf-8") if '"The survey says"' in line]
    assert sorted(places) == ["claims.py", "figure_set.py"], places


main(*sys.argv[1:])
