"""The guide's window: pages, pictures, parts, links, search."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices, QImage, QTextDocument
from PySide6.QtTest import QTest

from bozzetto_app.dialogs.guide import GuideDialog
from bozzetto_app.dialogs.guide_pages import FIRST_PAGE
from tests.app.seen import button


@pytest.fixture
def guide(qtbot):
    made = GuideDialog()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitExposed(made)
    return made


def images(text):
    """Names of the pictures that a page shows."""
    block = text.document().begin()
    while block.isValid():
        pieces = block.begin()
        while not pieces.atEnd():
            form = pieces.fragment().charFormat()
            if form.isImageFormat():
                yield form.toImageFormat().name()
            pieces += 1
        block = block.next()


def test_every_picture_is_shown_and_fits(guide):
    kind = QTextDocument.ResourceType.ImageResource.value
    names = list(images(guide.text))
    assert len(names) >= 15
    for name in names:
        picture = guide.text.loadResource(kind, QUrl(name))
        assert isinstance(picture, QImage), name
        assert 0 < picture.deviceIndependentSize().width() <= guide.text.viewport().width()
    for width in (980, 1300):
        guide.resize(width, 700)
        QTest.qWait(150)  # the text is laid out anew a moment after the last change of width
        guide.text.document().documentLayout().documentSize()
        assert guide.text.horizontalScrollBar().maximum() == 0, "nothing sticks out"


def test_nothing_outside_the_guide_is_read(guide, tmp_path):
    QImage(4, 4, QImage.Format.Format_RGB32).save(str(tmp_path / "strange.png"))
    kind = QTextDocument.ResourceType.ImageResource.value
    for name in (f"file://{tmp_path}/strange.png", "../../etc/passwd", "nowhere.png"):
        assert guide.text.loadResource(kind, QUrl(name)) is None
    guide.text.anchorClicked.emit(QUrl("../pyproject.toml"))
    assert guide.text.page == FIRST_PAGE


def test_a_part_of_the_list_is_gone_to(guide):
    names = [guide.contents.item(row).toolTip() for row in range(guide.contents.count())]
    assert names[:2] == ["The guide", "The first minute"]
    item = guide.contents.item(names.index("Posing"))
    guide.contents.itemClicked.emit(item)
    assert guide.text.textCursor().block().text() == "Posing"
    at = guide.text.cursorRect().top()
    assert 0 <= at <= 40, "at the top of what is seen"


def test_links_lead_to_headings_pages_and_back_and_the_web_opens_elsewhere(guide, monkeypatch):
    guide.text.anchorClicked.emit(QUrl("#surfaces-and-curves-for-cad"))
    assert guide.text.textCursor().block().text() == "Surfaces and curves for CAD"
    guide.text.anchorClicked.emit(QUrl("car.md#marks-files-marks_file"))
    assert guide.text.page == "car.md"
    assert guide.text.textCursor().block().text().startswith("Marks files")
    assert guide.contents.item(0).toolTip() != "The guide"
    assert button(guide, "Back to the guide").isVisible()
    button(guide, "Back to the guide").click()
    assert guide.text.page == FIRST_PAGE
    assert not button(guide, "Back to the guide").isVisible()
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", opened.append)
    guide.text.anchorClicked.emit(QUrl("https://example.org/"))
    assert [url.host() for url in opened] == ["example.org"]


def test_words_are_found_one_after_the_other_and_round_the_end(guide):
    QTest.keyClicks(guide.field, "barrel button")
    first = guide.text.textCursor().selectionStart()
    assert guide.text.textCursor().selectedText().lower() == "barrel button"
    places = [first]
    for _ in range(40):
        QTest.keyClick(guide.field, "\r")
        places.append(guide.text.textCursor().selectionStart())
        if places[-1] == first:
            break
    assert places[-1] == first
    guide.field.setText("no such words at all")
    assert guide.said.text()
    guide.field.clear()
    assert not guide.said.text()
