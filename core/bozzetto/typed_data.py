"""JSON, MessagePack and plain values made records of a type, from any thread.

msgspec prepares a type when it is first decoded, and hands a half-prepared one to a second thread
that asks for it meanwhile: the process then ends with a segmentation fault. Here types are prepared
one at a time, once.
"""

from __future__ import annotations

from threading import Lock
from typing import Any, Final, get_args, get_origin

import msgspec

__all__ = ["convert", "decode_in_turns", "decode_json", "decode_msgpack", "unaliased"]

LONG: Final = 1 << 18
"""Bytes of JSON from which on other threads get their turn while it is decoded."""

_json: dict[Any, msgspec.json.Decoder[Any]] = {}
_msgpack: dict[Any, msgspec.msgpack.Decoder[Any]] = {}
_preparing = Lock()


def decode_json(data: bytes | bytearray | memoryview | str | msgspec.Raw, kind: Any) -> Any:
    """Decode JSON as a type.

    Parameters
    ----------
    data : bytes-like, str or msgspec.Raw
        The text, UTF-8 where it is bytes.
    kind : type
        A struct, a dataclass or another type that msgspec knows; hashable.

    Returns
    -------
    object
        A value of the type.

    Raises
    ------
    msgspec.MsgspecError
        If the text is not JSON, or not of this type.
    """
    return _json_decoder(kind).decode(data)


def decode_in_turns(data: bytes | bytearray | memoryview | msgspec.Raw, kind: Any) -> Any:
    """Decode JSON as a type as `decode_json` does, row by row where it is long.

    One call of msgspec holds the interpreter till it is done, and the window with it: half a
    second for twenty megabytes. Rows of lists, and of the lists in a struct, are found first,
    a gigabyte a second, and decoded one by one.

    Raises
    ------
    msgspec.MsgspecError
        If the text is not JSON, or not of this type.
    """
    if len(memoryview(data)) < LONG:
        return decode_json(data, kind)
    if get_origin(kind) is list:
        (of,) = get_args(kind)
        return [decode_in_turns(row, of) for row in decode_json(data, list[msgspec.Raw])]
    if _is_plain_struct(kind):
        found = decode_json(data, dict[str, msgspec.Raw])
        fields = [field for field in msgspec.structs.fields(kind) if field.encode_name in found]
        values = {
            field.name: decode_in_turns(found[field.encode_name], field.type) for field in fields
        }
        absent = [
            field.name
            for field in msgspec.structs.fields(kind)
            if field.required and field.name not in values
        ]
        if absent:
            raise msgspec.ValidationError(f"Object missing required field `{absent[0]}`")
        return kind(**values)
    return decode_json(data, kind)


def _is_plain_struct(kind: Any) -> bool:
    """Whether a type is a struct that stands as an object in JSON, with any further fields."""
    if not (isinstance(kind, type) and issubclass(kind, msgspec.Struct)):
        return False
    config = kind.__struct_config__
    return not (config.array_like or config.forbid_unknown_fields or config.tag is not None)


def decode_msgpack(data: bytes | bytearray | memoryview, kind: Any) -> Any:
    """Decode MessagePack as a type; `decode_json` has the details."""
    decoder = _msgpack.get(kind)
    if decoder is None:
        with _preparing:
            decoder = _msgpack.setdefault(kind, msgspec.msgpack.Decoder(kind))
    return decoder.decode(data)


def convert(value: Any, kind: Any) -> Any:
    """Make plain values (dict, list, str, numbers) a value of a type; see `decode_json`."""
    _json_decoder(kind)  # prepares the type for every way to decode it
    return msgspec.convert(value, kind)


def unaliased(hint: Any) -> Any:
    """Return what a named alias of a type stands for (PEP 695); any other hint as it is.

    From NumPy 2.5 on, with Python 3.12 or later, ``NDArray[np.float64]`` is one.
    """
    origin = get_origin(hint)
    if hasattr(origin, "__value__"):
        return unaliased(origin.__value__[get_args(hint)])
    return unaliased(hint.__value__) if hasattr(hint, "__value__") else hint


def _json_decoder(kind: Any) -> msgspec.json.Decoder[Any]:
    decoder = _json.get(kind)
    if decoder is None:
        with _preparing:
            decoder = _json.setdefault(kind, msgspec.json.Decoder(kind))
    return decoder
