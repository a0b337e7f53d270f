"""What suits what is drawn is offered first when it is exported."""

from __future__ import annotations

import pytest

from bozzetto.exchange.formats import writers
from bozzetto_app.session.format_order import offered_formats, suiting_first


@pytest.mark.parametrize("exact", [False, True])
def test_the_order_loses_and_doubles_no_format(exact):
    given = writers("mesh", "curves")
    assert sorted(one.id for one in suiting_first(given, exact=exact)) == sorted(
        one.id for one in given
    )


@pytest.mark.parametrize(
    ("modeler", "first", "last"),
    [
        ("bozzetto.silhouette", "mesh", "curves"),
        ("bozzetto.symmetry", "surfaces", "mesh"),
    ],
)
def test_curves_are_offered_to_cad_first_and_solids_to_printers(
    make_session, settle, modeler, first, last
):
    session = make_session(modeler)
    (info,) = [one for one in session.toolbox.modelers if one.id == modeler]
    session.files.exchange.import_file(info.samples[-1])
    settle(session)
    offered = offered_formats(session)
    assert first in offered[0].holds
    assert last in offered[-1].holds
    assert first not in offered[-1].holds


def test_an_empty_or_mixed_sheet_is_offered_meshes_first(make_session, settle):
    session = make_session()
    assert offered_formats(session)[0].id == "stl"
    for info in session.toolbox.modelers[:2]:
        session.toolbox.take_modeler(info.id)
        session.files.exchange.import_file(info.samples[-1])
        settle(session)
    assert len({model.modeler for model in session.drawing.document}) == 2
    assert offered_formats(session)[0].id == "stl"
