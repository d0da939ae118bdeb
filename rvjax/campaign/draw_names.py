"""Names of draws in a campaign, and what is wrong with a name that is not a draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.law_words import in_words
from rvjax.campaign.plain_values import shorten
from rvjax.campaign.quantity import Quantity
from rvjax.campaign.variables import Variable, variables

MOST_SUGGESTIONS = 20

Wrong = tuple[str, str]
"""(message, what is accepted)."""


class Names:
    """The names of what a campaign draws and fixes. drawn: variables by the name of their stream; variable: of each draw."""

    def __init__(self, quantities: Mapping[str, Quantity]) -> None:
        self.drawn: dict[str, Variable] = variables(quantities)
        self.variable = {name: variable for variable in self.drawn.values() for name in variable.draws}
        self._asked = 0
        self._fixed = {component for name, quantity in quantities.items() for component in quantity.names(name)}.difference(
            self.variable
        )

    def draw(self, name: str) -> Wrong | None:
        """What is wrong with the name of a draw."""
        return self._known(name, list(self.variable))

    def _known(self, name: str, accepted: Sequence[str]) -> Wrong | None:
        """What is wrong with the name of a draw; of those accepted, some are proposed."""
        if name in self.variable:
            return None
        if name in self._fixed:
            return f"{shorten(name)} is fixed, not drawn", "accepted: the name of a draw"
        return f"{shorten(name)} is not a draw", self._suggestion(name, accepted)

    def scalar(self, name: str) -> Wrong | None:
        """What is wrong with the name of a draw that must have an independent law."""
        if name not in self.drawn and name in self.variable:
            variable = self.variable[name]
            message = f"{name} is drawn jointly with the other components of {variable.name}"
            return message, f"accepted: a draw with a scalar law, not {in_words(variable.law)}"
        return self._known(name, [draw for draw in self.variable if draw in self.drawn])

    def beginning(self, name: str) -> Wrong | None:
        """What is wrong with the name of some draws, or the beginning of their names."""
        if any(covers(name, draw) for draw in self.variable):
            return None
        if any(covers(name, draw) for draw in self._fixed):
            return f"nothing of {shorten(name)} is drawn", "accepted: names of draws, or the beginning of names"
        parts = [draw.split(".") for draw in self.variable]
        known = {".".join(steps[:length]): None for steps in parts for length in range(2, len(steps) + 1)}
        return f"{shorten(name)} is not a draw", self._suggestion(name, list(known))

    def _suggestion(self, name: str, known: Sequence[str]) -> str:
        """The nearest name, of the first few that are asked for: comparing words takes time."""
        self._asked += 1
        known = sorted(known, key=lambda draw: draw.startswith("controller."))  # last: a baseline may not have them
        suggestion = did_you_mean(name, known) if self._asked <= MOST_SUGGESTIONS else ""
        return suggestion if suggestion.startswith("did") else f"accepted: the name of a draw, such as {', '.join(known[:3])}"


def covers(beginning: str, name: str) -> bool:
    """Whether a name equals this beginning or continues it: pursuer.inertia_kgm2 covers pursuer.inertia_kgm2.moments.x."""
    return name == beginning or name.startswith(f"{beginning}.")
