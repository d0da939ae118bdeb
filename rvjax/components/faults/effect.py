"""Why a fault changes nothing in any sample, decided from its numbers without a flight."""

from __future__ import annotations

from collections.abc import Iterator

from rvjax.campaign import Spec
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem
from rvjax.campaign.schedule import Schedule
from rvjax.components.effect import Neutral, has, seen
from rvjax.components.faults.interface import FaultParameters


def problems(parameters: FaultParameters, neutral: Neutral, spec: Spec) -> Iterator[Problem]:
    """A problem for the whole fault, or else for each channel of its list `channels` and for each group of its schedule.

    parameters: on its channels only. neutral: of the component.
    """
    silent = {channel: reason for channel in parameters.channels if (reason := _silent(parameters, channel, neutral, spec))}
    if len(silent) == len(parameters.channels):
        yield next(iter(silent.values()))
        return
    if parameters.schedule is not None:
        if reason := _never_picks(parameters.schedule):
            yield reason
            return
        yield from _idle_groups(parameters, parameters.schedule)
    if len(parameters.channels) < len(parameters.onset_s.components):
        for channel, reason in silent.items():
            place = ("channels", parameters.channels.index(channel))
            yield Problem(f"on {channel}, {reason.message}", reason.accepted, place)


def _silent(parameters: FaultParameters, channel: str, neutral: Neutral, spec: Spec) -> Problem | None:
    """Why the fault changes nothing on a channel; None if it may change something."""
    place = parameters.onset_s.components.index(channel)
    for fields in neutral:
        if all(has(getattr(parameters, name), value, place) for name, value in fields.items()):
            words = " and ".join(f"{name} is {exact(value)}" for name, value in fields.items())
            return Problem(f"{words} in every sample", "accepted: another value", tuple(fields)[:1])
    low, high = parameters.onset_s.supports[place]
    if low >= spec.horizon.duration_s:
        message = f"the earliest onset of {exact(low)} s is not before the end of the flight"
        return Problem(message, f"accepted: an onset below {exact(spec.horizon.duration_s)} s", ("onset_s",))
    lasts = float("inf") if parameters.duration_s is None else parameters.duration_s.supports[place][1]
    length, period = lasts, None
    if parameters.period_s is not None and parameters.duty is not None:
        (shortest, longest), (_, duty) = parameters.period_s.supports[place], parameters.duty.supports[place]
        if shortest < longest:
            return None
        length, period = min(lasts, duty * longest), longest
    if seen(spec, low, high - low + length, period, high + lasts):
        return None
    half = 0.5 * spec.horizon.step_s
    message = f"from {low:.15g} s the fault acts for {length:g} s at a time, between two instants of the integration"
    key = "duration_s" if period is None else "duty"
    return Problem(message, f"accepted: {exact(half)} s (half a step) or longer, or a shorter step_s", (key,))


def _never_picks(schedule: Schedule) -> Problem | None:
    """A schedule in which no channel ever fails. The count is rounded to a whole number."""
    if schedule.count is not None and (most := schedule.count.supports[0][1]) <= 0.5:
        return Problem(f"a count of at most {exact(most)} picks no channel", "accepted: above 0.5", ("schedule", "count"))
    if schedule.probability is not None and schedule.probability.supports[0][1] <= 0.0:
        return Problem("a probability of 0 picks no channel", "accepted: above 0", ("schedule", "probability"))
    return None


def _idle_groups(parameters: FaultParameters, schedule: Schedule) -> Iterator[Problem]:
    """Groups that join nothing: fewer than two of their channels may fail, or all fail at the same fixed onset anyway."""
    supports = dict(zip(parameters.onset_s.components, parameters.onset_s.supports, strict=True))
    for index, group in enumerate(schedule.groups):
        able = [channel for channel in group if channel in parameters.channels]
        place, accepted = ("schedule", "groups", index), f"accepted: two or more out of {', '.join(parameters.channels)}"
        if len(able) < 2:
            yield Problem(f"of this group only {able[0] if able else 'no channel'} may fail", accepted, place)
        elif schedule.count is None and schedule.probability is None:
            times = {time for channel in able for time in supports[channel]}
            if len(times) == 1:
                yield Problem(
                    f"all channels of this group fail at {exact(times.pop())} s anyway", "accepted: other onsets", place
                )
