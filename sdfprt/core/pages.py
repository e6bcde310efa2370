"""HTML pages: a body from a template whose values are escaped, and a policy that lets only the page's own style and script run.

Names, titles and comments of scenes come from anywhere. jinja2 puts values in in one pass and escapes them; data for a script is
JSON in which no letter can end the element; and the Content-Security-Policy names our script and style by their SHA-256, so nothing
else would run even if it came to stand in the page.
"""

import base64
import functools
import hashlib
import json
from typing import Any

import jinja2
from markupsafe import Markup

from sdfprt.core.errors import SdfprtError

_LAYOUT = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{{ policy }}">
<title>{{ title }}</title>
<style>{{ style }}</style>
</head>
<body>
{{ body }}
{% if data %}<script id="data" type="application/json">{{ data }}</script>
{% endif %}{% if script %}<script>{{ script }}</script>
{% endif %}</body>
</html>
"""
# What could end a script's element, begin a comment in it, or end a line of it; in JSON all of these stand in strings only
_ESCAPES = {ord(letter): f"\\u{ord(letter):04x}" for letter in "<>&\u2028\u2029"}


def page(title: str, body: str, values: dict[str, Any], style: str, script: str = "", data: dict[str, Any] | None = None) -> str:
    """A whole page: the template `body` with `values`, and `data` for the script in an element `#data`.

    `body`, `style` and `script` are ours, and trusted; `title`, `values` and `data` are not. Pictures may be inside the page or
    beside it. Raises SdfprtError where a number in `data` is not finite.
    """
    policy = (
        f"default-src 'none'; script-src {_digest(script)}; style-src {_digest(style)}; img-src data: file: 'self'; "
        "base-uri 'none'; form-action 'none'"
    )
    return (
        _templates()
        .from_string(_LAYOUT)
        .render(
            policy=Markup(policy),
            title=title,
            style=Markup(style),
            body=Markup(_templates().from_string(body).render(title=title, **values)),
            data=Markup(as_data(data)) if data is not None else "",
            script=Markup(script),
        )
    )


def as_data(values: dict[str, Any]) -> str:
    """JSON that may stand inside a script's element; arrays become lists. Raises SdfprtError for NaN and infinity."""
    parts = []
    for name, value in values.items():
        try:
            text = json.dumps(value, separators=(",", ":"), allow_nan=False, default=_plain)
        except ValueError:
            raise SdfprtError(
                f"the page's {name} holds a number that is not finite; is the camera, light or material right?"
            ) from None
        parts.append(f"{json.dumps(name)}:{text}")
    return f"{{{','.join(parts)}}}".translate(_ESCAPES)


def _plain(value: Any) -> Any:
    """Of numpy."""
    return value.tolist()


def _digest(text: str) -> str:
    """A source of the policy: what has this text, or nothing."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" if text else "'none'"


@functools.cache
def _templates() -> jinja2.Environment:
    return jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
