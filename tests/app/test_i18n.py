"""Words: all of them can be translated."""

from __future__ import annotations

import ast
import shutil
import string
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QCoreApplication, QTranslator

import bozzetto_app
from bozzetto_app.i18n import tr

APP = Path(bozzetto_app.__file__).parent


def calls_of_tr():
    for path in sorted(APP.rglob("*.py")):
        if path.name == "words.py":
            continue
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "tr":
                yield path.relative_to(APP), node


def test_every_text_is_a_literal():
    count = 0
    for path, node in calls_of_tr():
        count += 1
        where = f"{path}:{node.lineno}"
        assert len(node.args) == 2, where
        for argument in node.args:
            assert isinstance(argument, ast.Constant), f"{where}: not a plain literal"
            assert isinstance(argument.value, str), where
    assert count > 100


def test_every_place_is_filled():
    for path, node in calls_of_tr():
        if node.keywords:
            text = node.args[1].value
            places = {name for _, name, _, _ in string.Formatter().parse(text) if name}
            assert places == {keyword.arg for keyword in node.keywords}, f"{path}:{node.lineno}"


def test_values_are_inserted_as_they_are(qapp):
    assert tr("Test", "Open “{name}”", name="{0.__class__}") == "Open “{0.__class__}”"


def test_braces_without_values_stay(qapp):
    assert tr("Test", "{name}") == "{name}"


class _Upper(QTranslator):
    def translate(self, context, text, disambiguation=None, n=-1):
        return "Öffne {name}" if text == "Open {name}" else ""

    def isEmpty(self):
        return False


def test_translations_are_used(qapp):
    translator = _Upper()
    QCoreApplication.installTranslator(translator)
    try:
        assert tr("Test", "Open {name}", name="A") == "Öffne A"
    finally:
        QCoreApplication.removeTranslator(translator)


def test_the_extractor_finds_the_words(tmp_path):
    tool = shutil.which("pyside6-lupdate", path=str(Path(sys.executable).parent))
    if tool is None:
        pytest.skip("lupdate is not installed")
    made = tmp_path / "de.ts"
    source = str(APP / "panels/status_line.py")
    subprocess.run(
        [tool, "-tr-function-alias", "translate+=tr", source, "-ts", str(made)],
        check=True,
        capture_output=True,
        timeout=60,
    )
    found = made.read_text("utf-8")
    assert "<name>FaultBar</name>" in found
    assert "<source>Switch off</source>" in found
