"""Loading of one plugin, and checks of what it delivers."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping, Sequence, Set
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final

from bozzetto.errors import UserError, words_of
from bozzetto.plugin.overrides import overrides

if TYPE_CHECKING:
    import pluggy

    from bozzetto.plugin.modeler import Modeler

METHODS: Final = ("read_shapes", "follow", "add_picture", "add_drawing")
"""Methods of `Modeler` that the manifest names among the abilities where they are overridden."""


class Undelivered(UserError):
    """A plugin does not deliver what its manifest announces; tells its author in a sentence."""


def import_plugin(plugins: pluggy.PluginManager, package: str, plugin_id: str) -> None:
    """Import a plugin's package and take in its hooks.

    Raises
    ------
    Undelivered
        If a hook's name or an argument does not exist.
    BaseException
        Whatever the import raises.
    """
    import pluggy

    module: ModuleType = importlib.import_module(package)
    try:
        plugins.register(module, plugin_id)
        plugins.check_pending()
    except pluggy.PluginValidationError as problem:
        if plugins.has_plugin(plugin_id):
            plugins.unregister(name=plugin_id)
        said = words_of(problem)
        raise Undelivered(f"One of its hooks does not exist as written: {said}.") from None


def ask(plugins: pluggy.PluginManager, plugin_id: str, hook: str, **arguments: Any) -> list[Any]:
    """Call a hook of one plugin alone and return its answers."""
    others = [plugin for name, plugin in plugins.list_name_plugin() if name != plugin_id]
    answers: list[Any] = plugins.subset_hook_caller(hook, others)(**arguments)
    return answers


def check_modelers(
    answers: Sequence[Any], announced: Mapping[str, Set[str]]
) -> dict[str, Modeler[Any, Any]]:
    """Check the modelers that a plugin delivers and return them by id.

    Parameters
    ----------
    answers : sequence
        What its `bozzetto_modelers` hooks gave.
    announced : mapping of str to set of str
        Abilities by the ids in its manifest.

    Raises
    ------
    Undelivered
        If they are not those announced, or one cannot do what the manifest says.
    """
    found: dict[str, Modeler[Any, Any]] = {}
    for answer in answers:
        if not isinstance(answer, list | tuple):
            raise Undelivered(
                f"bozzetto_modelers gave {type(answer).__name__} where a list of modelers belongs."
            )
        for modeler in answer:
            _look_over(modeler)
            _compare_abilities(modeler, announced.get(modeler.id, frozenset()))
            if modeler.id in found:
                raise Undelivered(f"It delivers the modeler {modeler.id} twice.")
            found[modeler.id] = modeler
    missing = sorted(set(announced) - set(found))
    unannounced = sorted(set(found) - set(announced))
    if missing:
        advice = "See that the function has the decorator @hookimpl."
        if unannounced:
            advice = f"It delivers {', '.join(unannounced)}: write one id in both places."
        raise Undelivered(
            f"Its manifest announces {', '.join(missing)}, and bozzetto_modelers does not "
            f"deliver it. {advice}"
        )
    if unannounced:
        raise Undelivered(f"It delivers {', '.join(unannounced)}, which its manifest lacks.")
    return found


def _look_over(modeler: Any) -> None:
    if isinstance(modeler, type):
        name = modeler.__name__
        raise Undelivered(f"bozzetto_modelers gave the class {name} itself. Give {name}().")
    from bozzetto.plugin.modeler import Modeler  # it imports numpy
    from bozzetto.plugin.parts import PartsModeler, PartsState

    name = type(modeler).__name__
    if not isinstance(modeler, Modeler):
        raise Undelivered(f"{name} is not derived from bozzetto.plugin.Modeler.")
    if not isinstance(getattr(modeler, "id", None), str):
        raise Undelivered(f"{name}.id must be a text.")
    state_type = getattr(modeler, "state_type", None)
    frozen = getattr(getattr(state_type, "__dataclass_params__", None), "frozen", False)
    if not (isinstance(state_type, type) and dataclasses.is_dataclass(state_type) and frozen):
        raise Undelivered(f"{name}.state_type must be a frozen dataclass.")
    version = getattr(modeler, "state_version", None)
    if type(version) is not int or version < 1:
        raise Undelivered(f"{name}.state_version must be a whole number from 1.")
    if isinstance(modeler, PartsModeler) != issubclass(state_type, PartsState):
        raise Undelivered(
            f"{name} and {state_type.__name__} belong together: derive the modeler from "
            "PartsModeler and its state from PartsState, or neither."
        )
    _look_over_words(modeler, (state_type, *getattr(modeler, "part_types", ())))


def _look_over_words(modeler: Any, state_types: tuple[type[Any], ...]) -> None:
    """Refuse words of figures that cannot be said, and first parameters that are none."""
    from bozzetto.plugin.guard import answer_validation as validation
    from bozzetto.plugin.guard.checked_values import Unsound

    try:
        validation.sound_figures(modeler.figures)
        validation.sound_first_parameters(modeler.first_parameters, state_types)
    except Unsound as problem:
        raise Undelivered(f"{type(modeler).__name__}: {problem}.") from None


def _compare_abilities(modeler: Any, announced: Set[str]) -> None:
    """Refuse a modeler that can do more or less than a menu would offer."""
    links = [method for method in ("follow", "with_sources") if not overrides(modeler, method)]
    if links and overrides(modeler, "sources"):
        raise Undelivered(
            f"{type(modeler).__name__} has sources and not {links[0]}: write the three together."
        )
    for method in METHODS:
        able = overrides(modeler, method)
        if able and method not in announced:
            raise Undelivered(
                f'{type(modeler).__name__} has {method}: write abilities = ["{method}"] under '
                f"its [[modeler]] in the manifest."
            )
        if method in announced and not able:
            raise Undelivered(
                f"The manifest says that {modeler.id} can {method}, and "
                f"{type(modeler).__name__} does not override it."
            )
