"""Nothing that a scene, a light or a test is called becomes markup of a page, and only the page's own code may run."""

import base64
import hashlib
import html.parser
import json
import re

import nets
import numpy as np
import pytest

from sdfprt import Light, Scene, SdfprtError
from sdfprt.core import pages
from sdfprt.export.page import export_html
from sdfprt.truth import report

TITLES = (
    "SCENE_DATA", "{{ policy }}", "{% raw %}", "<!-- <script>", "</script><img src=x onerror=alert(1)>", '" onload="alert(1)',
    "</title><svg onload=alert(1)>", "\u2028alert(1)", "<plaintext>", "&lt;b&gt;",
)  # fmt: skip


class Elements(html.parser.HTMLParser):
    """Elements with their attributes, the title as it is shown, and the texts of scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.seen: list[tuple[str, tuple[str, ...]]] = []
        self.texts: dict[str, list[str]] = {}
        self.inside = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.seen.append((tag, tuple(name for name, _ in attrs)))
        self.inside = tag

    def handle_endtag(self, tag: str) -> None:
        self.inside = ""

    def handle_data(self, data: str) -> None:
        self.texts.setdefault(self.inside, []).append(data)


def _exported(title: str) -> str:
    glsl = f"// {title.splitlines()[0]}\nfloat sdf(vec3 p) {{ return length(p) - 0.5; }}"
    light = Light(np.ones((2, 4, 3), np.float32), title)
    return export_html(Scene(glsl=glsl, title=title, name=title), nets.random_net(), light, size=(8, 8))


def test_no_title_comment_or_name_adds_an_element():
    plain = Elements(_exported("plain"))
    for title in TITLES:
        found = Elements(_exported(title))
        assert found.seen == plain.seen, title
        assert "".join(found.texts["title"]) == "".join(found.texts["h1"]) == title
        data = json.loads("".join(found.texts["script"]).split("\n")[0].partition('"use strict"')[0])
        assert data["lights"][0]["name"] == title


def test_the_policy_names_the_scripts_own_hash_and_allows_nothing_inline():
    text = _exported("plain")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy and "unsafe" not in policy[1] and "default-src 'none'" in policy[1]
    for kind in ("script", "style"):
        inner = re.search(rf"<{kind}>(.*?)</{kind}>", text, re.S)
        assert inner
        digest = base64.b64encode(hashlib.sha256(inner[1].encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}';" in policy[1]
    assert not re.search(r"<[^>]* (style|on\w+)=", text)


def test_the_reports_page_escapes_what_it_is_told():
    section = {"title": "<i>", "figures": [{"pictures": ["data:image/png;base64,"], "caption": "<img>", "numbers": "<b>"}]}
    row = report.BandRow("<s>", 4, 4, 4, 30.0, 0.1, 1.0)
    way = report.WayRow("<tt>", "<s>", 30.0, 0.1, 0.2)
    found = Elements(report._page("<u>", "<em>", [], [row], [way], [section]))
    assert {"i", "b", "s", "u", "em", "tt"}.isdisjoint(tag for tag, _ in found.seen)
    assert [tag for tag, _ in found.seen].count("img") == 1


def test_data_for_a_script_cannot_end_it_and_keeps_its_values():
    values = {"a": "</script><!--\u2028&", "b": np.arange(3), "c": np.float64(0.5)}
    text = pages.as_data(values)
    assert not set("<>&\u2028\u2029") & set(text)
    assert json.loads(text) == {"a": values["a"], "b": [0, 1, 2], "c": 0.5}


@pytest.mark.parametrize("value", [float("nan"), float("inf"), [1.0, -float("inf")], np.array([np.nan])])
def test_numbers_that_json_does_not_know_are_refused_by_name(value: object):
    with pytest.raises(SdfprtError, match="camera holds a number that is not finite"):
        pages.as_data({"size": [1, 2], "camera": {"eye": value}})
