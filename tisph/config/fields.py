"""Field types that pydantic does not have: members of a family, a number or one word, and the section ``bodies``."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, GetCoreSchemaHandler, Tag, ValidationError, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from tisph import registry
from tisph.config.base import Model, refusal, refusals

OTHER_TAG = "<other>"
USUAL_TAG_START = "<or "

MOST_BODIES = 100


def nearest(word: object, choices: Iterable[str]) -> str:
    """Return ``"; nearest: NAME"`` for the choice most similar to ``word``, an empty text where none is similar."""
    matches = get_close_matches(str(word), list(choices), n=1, cutoff=0.6)
    return f"; nearest: {matches[0]}" if matches else ""


def one_of(choices: list[str]) -> str:
    """Return the words of a message for a value with these choices."""
    return "must be " + ("one of " if len(choices) > 1 else "") + ", ".join(choices)


def number_or(number: Any, word: str) -> Any:
    """Return the type of a value that is a number of type ``number``, or the one word ``word``."""
    return either(number, Literal[word], lambda value: value == word, word)


def either(usual: Any, other: Any, is_other: Callable[[Any], bool], words: str) -> Any:
    """Return the type of a value that is of type ``other`` where ``is_other(value)``, else of type ``usual``.

    ``words``: description of the other type in messages.
    """
    usual_tag = f"{USUAL_TAG_START}{words}>"
    return Annotated[
        Annotated[usual, Tag(usual_tag)] | Annotated[other, Tag(OTHER_TAG)],
        Discriminator(lambda value: OTHER_TAG if is_other(value) else usual_tag),
    ]


def member_name(family: str) -> Any:
    """Return the type of a value that is the name of a member of ``family``."""

    def check(name: str) -> str:
        members = registry.names(family)
        if name not in members:
            raise refusal(one_of(members) + nearest(name, members))
        return name

    return Annotated[str, AfterValidator(check)]


@dataclass(frozen=True)
class Member:
    """Marks a map ``{type: NAME, ...}`` whose other keys are the ``Parameters`` of a family's member.

    ``usual``: name of the member where the map, or its ``type``, is left out. With ``untyped`` a map without ``type``
    is of the member with its keys: of ``untyped`` if it has all keys, else of ``usual`` if that has them.
    """

    family: str
    usual: str
    untyped: str | None = None

    def default(self) -> Model:
        """Return the parameters of the usual member, all at their defaults."""
        return registry.load(self.family, self.usual).Parameters()

    def model(self, value: object) -> type[Model] | None:
        """Return the parameter model for the raw map ``value``, by its ``type``; None where there is none."""
        if not isinstance(value, dict):
            return None
        name = value["type"] if "type" in value else self._meant(value)
        if name not in registry.names(self.family):
            return None
        return registry.load(self.family, name).Parameters

    def _meant(self, value: dict[str, Any]) -> str:
        """Return the name of the member that accepts ``value``, else of the member that has most of its keys."""
        if self.untyped is None:
            return self.usual
        names = [self.untyped, self.usual, *registry.names(self.family)]
        models = {name: registry.load(self.family, name).Parameters for name in names}
        for name, model in models.items():
            with suppress(ValidationError):
                model.model_validate(value)
                return name
        return max(models, key=lambda name: len(models[name].model_fields.keys() & value.keys()))

    def _validate(self, value: object, info: ValidationInfo) -> Model:
        if isinstance(value, Model):
            return value
        model = self.model(value)
        if model is None:
            raise self._refuse(value)
        return model.model_validate(value, context=info.context)

    def _refuse(self, value: object) -> Exception:
        members = registry.names(self.family)
        if not isinstance(value, dict):
            return refusal(f"must be a map such as {{type: {members[0]}}}")
        return refusals([(("type",), one_of(members) + nearest(value["type"], members), value["type"])])

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        serialization = core_schema.plain_serializer_function_ser_schema(lambda model: model.model_dump())
        return core_schema.with_info_plain_validator_function(self._validate, serialization=serialization)


def bodies(required: bool = False) -> Any:
    """Return the type of the section ``bodies``: a list of shapes, not empty where ``required``, or a suspension.

    The modules of shapes are imported only when a config names them.
    """
    shapes = tuple[Annotated[Any, Member("bodies", usual="circle")], ...]
    listed: Any = Annotated[shapes, Field(strict=False, max_length=MOST_BODIES)]
    if required:  # ``min_length`` would call a list empty whose only item is wrong
        listed = Annotated[listed, AfterValidator(_not_empty)]
    suspension = Annotated[Any, Member("suspensions", usual="random_circles")]
    return either(listed, suspension, _is_suspension, "a map such as {type: random_circles}")


def _not_empty(value: tuple[Any, ...]) -> tuple[Any, ...]:
    if not value:
        raise refusal("must not be empty")
    return value


def _is_suspension(value: Any) -> bool:
    """Return whether ``value`` is a map, but no map of one shape, which should be in a list."""
    return isinstance(value, Model) or (isinstance(value, dict) and value.get("type") not in registry.names("bodies"))


Bodies = bodies()
"""Type of a section ``bodies`` that may be left out."""
