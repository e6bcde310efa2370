"""The compiler reads nothing but its text, is found only where packages are installed, and says which limit it reached."""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from sdfprt.core import settings
from sdfprt.core.errors import GlslError
from sdfprt.glsl import compile as compiling
from sdfprt.glsl.compile import check_es, compile_glsl, file_marker, preprocessed
from sdfprt.glsl.directives import directives, plain_directives

VERSION = "#version 430\n"
HIDDEN = [
    '#/**/include "SECRET"',
    '#/* \n */include "SECRET"',
    '#in\\\nclude "SECRET"',
    '#\\\n\\\ninclude "SECRET"',
    '/* a */ # /* b */ include "SECRET"',
    '"/*"\n#include "SECRET"\n"*/"',
    "#include <SECRET>",
    '// a comment " with one quote\n#include "SECRET"',
    "/\\\n* a comment *\\\n/ #include SECRET",
]


@pytest.mark.parametrize("text", HIDDEN)
@pytest.mark.parametrize("extension", ["#extension GL_GOOGLE_include_directive : require", "#/**/extension all : enable", ""])
def test_the_compiler_opens_no_file_by_any_spelling(tmp_path: Path, text: str, extension: str) -> None:
    secret = tmp_path / "secret.glsl"
    secret.write_text("const float SECRET_NUMBER = 0.25;\n")
    whole = f"{VERSION}{extension}\n{text.replace('SECRET', str(secret))}\nvoid main() {{ float x = SECRET_NUMBER; }}\n"
    for road in (compile_glsl, check_es, preprocessed):
        with pytest.raises(GlslError, match=r"^scene\.glsl:\d+: #(include|extension) cannot be read here"):
            road(whole)


def test_includes_in_comments_are_no_includes() -> None:
    text = '// #include "a.glsl"\n/* #include "b.glsl"\n#extension x : require */\n// include\nvoid main() {}\n'
    assert compile_glsl(VERSION + text)


def test_directives_are_plain_and_lines_stay_where_they_were() -> None:
    text = 'a\n#/* b\nc */inc\\\nlude "x.glsl" // why\nd\n# /**/ define E(x) \\\n  x\nf // g \\\n#include "h"\ni\n'
    plain = plain_directives(text)
    assert '\n#include "x.glsl"\n' in plain and "\n#define E(x) \\\n  x\n" in plain and '#include "h"' not in plain
    assert [k for k, line in enumerate(plain.split("\n")) if line in ("a", "d", "i")] == [0, 4, 9]
    assert [(d.line, d.name) for d in directives(text)] == [(2, "include"), (6, "define")]
    assert plain_directives(plain) == plain


def test_macros_that_double_reach_the_limit_of_memory_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "Compile", replace(settings.Compile(), memory=256 << 20))
    bomb = "".join(f"#define A{k + 1}(x) A{k}(x x)\n" for k in range(1, 40)) + "#define A1(x) x x\n"
    with pytest.raises(GlslError, match=r"^b\.glsl: compiling needs more than 256 MB of memory: macros"):
        compile_glsl(f"{VERSION}{bomb}void main() {{ float x = 1.0 A40(+0.0); }}\n", file="b.glsl")


def test_output_and_time_have_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "Compile", replace(settings.Compile(), output=1000))
    with pytest.raises(GlslError, match="larger than"):
        preprocessed(VERSION + "float x;\n" * 1000)
    monkeypatch.setattr(compiling, "Compile", replace(settings.Compile(), seconds=0))
    with pytest.raises(GlslError, match="longer than 0 s"):
        compile_glsl(VERSION + "void main() {}\n")


def test_no_program_is_found_through_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planted = tmp_path / "cmeel.prefix" / "bin" / "glslang"
    planted.parent.mkdir(parents=True)
    planted.write_text(f"#!/bin/sh\ntouch {tmp_path}/was_run\n")
    planted.chmod(0o755)
    (tmp_path / "glslang").write_bytes(planted.read_bytes())
    (tmp_path / "glslang").chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PATH", f".:{os.pathsep}{os.environ['PATH']}")
    assert compile_glsl(VERSION + "void main() {}\n")
    monkeypatch.setattr(compiling, "_installed", list)
    try:
        assert not compiling._glslang()[0].startswith((".", str(tmp_path)))
    except Exception as error:
        assert "glslang is missing" in str(error)
    assert not (tmp_path / "was_run").exists()


def test_the_compiler_starts_in_a_folder_of_its_own_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    compile_glsl(VERSION + "void main() {}\n")
    assert not list(tmp_path.iterdir())


def test_errors_name_the_file_whose_marker_goes_before() -> None:
    included = f"{VERSION}#line 1\nfloat a;\n{file_marker(3, 'lib/b.glsl')}\nfloat b;\nfloat c = nothing;\nvoid main() {{}}"
    with pytest.raises(GlslError, match=r"^lib/b\.glsl:2: no variable 'nothing'"):
        compile_glsl(included, file="s.glsl")
    own = f"{VERSION}{file_marker(3, 'lib/b.glsl')}\nfloat b;\n{file_marker(0, '', 3)}\nfloat d = none;\nvoid main() {{}}"
    with pytest.raises(GlslError, match=r"^s\.glsl:3: no variable 'none'"):
        compile_glsl(own, file="s.glsl")
