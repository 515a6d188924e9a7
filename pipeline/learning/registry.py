"""The neural methods: every folder here whose package declares a `METHOD`."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

from pipeline import learning
from pipeline.learning.method import MODEL_CONFIG, Method


@cache
def methods() -> Mapping[str, Method]:
    """Return the methods by the names of their folders, sorted.

    Raises:
        TypeError: A folder declares something else, or a kind of network that another one has.
    """
    found: dict[str, Method] = {}
    owners: dict[str, str] = {}
    for module in sorted(pkgutil.iter_modules(learning.__path__), key=lambda m: m.name):
        if not module.ispkg:
            continue
        method = getattr(import_module(f"{learning.__name__}.{module.name}"), "METHOD", None)
        if not isinstance(method, Method):
            raise TypeError(
                f"pipeline.learning.{module.name} must declare METHOD, a Method; got {method!r}"
            )
        for kind in method.kinds:
            if kind in owners:
                raise TypeError(f"{owners[kind]} and {module.name} both declare model.kind={kind}")
            owners[kind] = module.name
        found[module.name] = method
    return MappingProxyType(found)


def kinds() -> tuple[str, ...]:
    """Return every kind of network that can be built: the values of ``model.kind``."""
    return tuple(kind for method in methods().values() for kind in method.kinds)


def method_of(kind: str) -> Method:
    """Return the method whose networks ``model.kind`` names.

    Raises:
        KeyError: There is none; configurations are checked against `kinds` before.
    """
    for method in methods().values():
        if kind in method.networks:
            return method
    raise KeyError(kind)


def config_class(kind: str) -> type[Any]:
    """Return the dataclass of the keys of ``model`` for a kind of network.

    For a kind that no method declares it is the common one, which refuses the kind.
    """
    declared = [method.config for method in methods().values() if kind in method.networks]
    found: type[Any] = imported(declared[0] if declared else MODEL_CONFIG)
    return found


def config_classes() -> tuple[type[Any], ...]:
    """Return the dataclasses of the keys of ``model``, of all kinds of networks."""
    return tuple(imported(name) for name in sorted({m.config for m in methods().values()}))


def imported(name: str) -> Any:
    """Import what a dotted name stands for."""
    module, _, attribute = name.rpartition(".")
    return getattr(import_module(module), attribute)


def declared_modules(kind: str) -> tuple[str, ...]:
    """Return the modules that building and training a network of a kind imports by name.

    They are declared as strings, so tools that follow imports in the source do not see them, nor
    the packages of all methods, which are looked through for the kind.
    """
    method = method_of(kind)
    classes = (method.networks[kind], method.objective, method.config)
    packages = (f"{learning.__name__}.{name}" for name in methods())
    return (*(name.rpartition(".")[0] for name in classes), *packages)


def kinds_in(module: str) -> tuple[str, ...]:
    """Return the kinds of networks of the method whose folder a module lies in; none elsewhere."""
    name = module.removeprefix(f"{learning.__name__}.").partition(".")[0]
    return methods()[name].kinds if name in methods() else ()
