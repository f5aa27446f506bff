"""Defaults of functions by their names, where their values would fill a page."""

from types import FunctionType


class _Named:
    """What a default is called, in place of what it is."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __repr__(self) -> str:
        return self._name


def _named(value: object) -> object:
    from tendon_mj import CATALOGUE

    if value is CATALOGUE:
        return _Named("CATALOGUE")
    return _Named(value.__name__) if isinstance(value, FunctionType | type) else value


def _process(app, thing, bound: bool) -> None:
    if isinstance(thing, FunctionType):
        if thing.__defaults__:
            thing.__defaults__ = tuple(map(_named, thing.__defaults__))
        if thing.__kwdefaults__:
            thing.__kwdefaults__ = {k: _named(v) for k, v in thing.__kwdefaults__.items()}


def setup(app):
    """Come before a signature is written."""
    app.connect("autodoc-before-process-signature", _process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
