"""Tools of one group share a button, a key, and take turns."""

from __future__ import annotations

from bozzetto_app.session.tool_groups import TOOL_KEYS, groups_of, keys_of
from tests.app.fake_session import ToolInfo


def tools(*groups: str):
    return tuple(ToolInfo(f"t{k}", f"T{k}", None, "", group=each) for k, each in enumerate(groups))


def test_a_group_stands_where_its_first_tool_does():
    found = groups_of(tools("", "Edges", "", "Edges"))
    assert [(each.title, [tool.id for tool in each.tools]) for each in found] == [
        ("T0", ["t0"]),
        ("Edges", ["t1", "t3"]),
        ("T2", ["t2"]),
    ]


def test_a_group_of_one_is_a_tool():
    (one,) = groups_of(tools("Edges"))
    assert one.title == "T0"


def test_a_group_may_be_called_like_the_id_of_a_tool():
    assert len(groups_of(tools("", "t0", "t0"))) == 2


def test_all_tools_of_the_first_ten_groups_have_a_key():
    keys = keys_of(groups_of(tools(*(f"G{k // 2}" for k in range(22)))))
    assert [keys.get(f"t{k}") for k in range(22)] == [
        *(key for key in TOOL_KEYS for _ in range(2)),
        None,
        None,
    ]


def test_tools_of_a_group_take_turns():
    (group,) = groups_of(tools("Edges", "Edges", "Edges"))
    assert [group.after(f"t{k}").id for k in range(3)] == ["t1", "t2", "t0"]
    assert group.tool_of("elsewhere", "", "t2").id == "t2"
    assert group.tool_of().id == "t0"
