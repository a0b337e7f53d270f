"""Modelers' states as JSON, strokes and arrays; and the states of modelers that are absent."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar, cast

import msgspec
from numpy.typing import NDArray

from bozzetto.document.model import OpaqueState
from bozzetto.document.storage.side_tables import Aside, Refusal
from bozzetto.document.storage.type_forms import DataclassForm, form_of
from bozzetto.errors import DocumentError, UserError, words_of
from bozzetto.ink.stroke import Stroke
from bozzetto.json_size import MAX_VALUES, json_values

if TYPE_CHECKING:
    from bozzetto.parameters import Field

State = TypeVar("State")

MAX_STATE_JSON: Final = 16 << 20
"""Longest JSON of one state, bytes: read, it may take a dozen times as much memory."""


class StateTypes(Protocol):
    """Source of modelers' state types, such as `bozzetto.plugin.host.registry.Registry`."""

    def state_type(self, modeler_id: str) -> tuple[type[Any], int] | None:
        """Return the state type and version of a modeler, or None if it is absent or broken."""
        ...

    def upgrade(self, modeler_id: str, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Return the stored form of an older version's state in today's shape."""
        ...

    def sources(self, modeler_id: str, state: Any) -> tuple[str, ...]:
        """Return the ids of the models that a state is made from.

        Raises
        ------
        DocumentError
            If the modeler cannot say it.
        """
        ...


@dataclass(frozen=True, eq=False)
class EncodedState:
    """A state taken apart.

    Parameters
    ----------
    json : bytes
        Refers to strokes and arrays by their place in the other two.
    strokes : tuple of Stroke
    arrays : tuple of read-only array
    """

    json: bytes
    strokes: tuple[Stroke, ...] = ()
    arrays: tuple[NDArray[Any], ...] = ()


def check_encodable(state_type: type[Any], state: object, before: object = None) -> None:
    """Make sure that a state can be stored and will be read back.

    Parameters
    ----------
    state_type : type
        The modeler's frozen dataclass.
    state : object
        The state.
    before : object, optional
        A state that can be stored. Where only numbers and switches of `state` are others, only
        these are looked at: a slider that is dragged makes many such states.

    Raises
    ------
    TypeError
        If the state is of another type, or its fields are of a kind that documents cannot
        keep.
    ValueError
        If the state holds something else than its type says, a number that is not finite,
        an array that can be written to, or a parameter out of range. Names the place.
    """
    if type(state) is not state_type:
        raise TypeError(f"{type(state).__name__} where {state_type.__name__} belongs")
    if type(before) is not state_type or not _only_numbers_differ(state, before):
        encode_state(state)


def _only_numbers_differ(state: Any, before: Any) -> bool:
    """Whether all but numbers and switches are the very same objects; these are checked then."""
    form = form_of(type(state))
    if not isinstance(form, DataclassForm):
        return False
    changed = [name for name in form.fields if getattr(state, name) is not getattr(before, name)]
    if not all(type(getattr(state, name)) in (bool, int, float) for name in changed):
        return False
    aside = Aside()
    for name in changed:
        try:
            form.fields[name][0].write(getattr(state, name), aside)
        except Refusal as refusal:
            refusal.where.append(f".{name}")
            raise
    _check_parameters(state)
    return True


def encode_state(state: Any) -> EncodedState:
    """Take a state apart; an `OpaqueState` comes out as it went in.

    Raises
    ------
    TypeError, ValueError
        As `check_encodable`.
    """
    if isinstance(state, OpaqueState):
        return EncodedState(state.json, tuple(state.strokes), state.arrays)
    aside = Aside()
    try:
        text = msgspec.json.encode(form_of(type(state)).write(state, aside))
    except RecursionError:
        raise ValueError("state: nested too deeply") from None
    if len(text) > MAX_STATE_JSON or json_values(text) > MAX_VALUES:
        raise ValueError(f"state: {len(text)} bytes of JSON; keep long rows of numbers as arrays")
    _check_parameters(state)
    return EncodedState(text, tuple(aside.strokes), tuple(aside.arrays))


def decode_state(
    state_type: type[State],
    encoded: EncodedState,
    *,
    upgrade: Callable[[dict[str, Any]], dict[str, Any]] | None = None,
) -> State:
    """Put a state together again.

    Parameters
    ----------
    state_type : type
        The modeler's frozen dataclass.
    encoded : EncodedState
        The state as `encode_state` gives it.
    upgrade : callable, optional
        Turns the JSON object of an older version into today's.

    Raises
    ------
    DocumentError
        If what was stored is not a state of this type.
    """
    try:
        if len(encoded.json) > MAX_STATE_JSON:
            raise ValueError(f"{len(encoded.json)} bytes of JSON")
        if json_values(encoded.json) > MAX_VALUES:
            raise ValueError(f"more than {MAX_VALUES} values of JSON")
        raw = msgspec.json.decode(encoded.json)
        if upgrade is not None:
            raw = upgrade(raw)
        aside = Aside(list(encoded.strokes), list(encoded.arrays))
        state: State = form_of(state_type).read(raw, aside)
        _check_parameters(state)
    except Exception as problem:  # types, checks and upgrades are the plugin's code
        raise DocumentError(f"{type(problem).__name__}: {words_of(problem)}") from problem
    return state


def state_digest(state: Any) -> bytes:
    """Return 16 bytes that name a state's content; equal states have equal ones."""
    encoded = encode_state(state)
    import hashlib

    digest = hashlib.blake2b(encoded.json, digest_size=16)
    for stroke in encoded.strokes:
        digest.update(stroke.digest)
    for array in encoded.arrays:
        digest.update(f"{array.dtype}{array.shape}".encode())
        digest.update(array.tobytes())
    return digest.digest()


def _check_parameters(state: Any) -> None:
    """Raise ValueError where a parameter is out of its range."""
    for entry in _parameters(cast(Hashable, type(state))):
        try:
            entry.check(getattr(state, entry.name))
        except UserError as problem:
            raise ValueError(f"state.{entry.name}: {problem}") from problem


@cache
def _parameters(state_type: Hashable) -> tuple[Field, ...]:
    from bozzetto.parameters import parameter_fields  # the contract imports this room

    return parameter_fields(cast("type[Any]", state_type))
