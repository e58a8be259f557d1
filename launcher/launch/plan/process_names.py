"""The names of the processes of a plan, as a run gives them.

A process gets its number when it is requested. Which one comes first is known of what the launch
file and its timers start, and of what one event causes. Where it is not, a name has no number.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from launcher.launch.plan.certainty import is_certain

if TYPE_CHECKING:
    from launcher.launch.plan.planner import Occasion, Plan, Stamp

    # The events that lead to a stamp, first the start (None): each with the time of what it was
    # that the next one is about.
    Chain = list[tuple[Occasion | None, float]]


def process_names(plan: Plan) -> list[str]:
    """By the index of the process: `robot_3-5`, or `robot_3` if its number is not known."""
    chains = [_chain(process.stamp) for process in plan.processes]
    is_complete = is_certain(plan)
    return [
        process.spec.name
        if _is_known(chain, chains, is_complete=is_complete)
        else process.spec.label
        for process, chain in zip(plan.processes, chains, strict=True)
    ]


def _chain(stamp: Stamp) -> Chain:
    chain: Chain = [(stamp.occasion, stamp.time_s)]
    while stamp.occasion is not None:
        stamp = stamp.occasion.before
        chain.append((stamp.occasion, stamp.time_s))
    return chain[::-1]


def _is_known(chain: Chain, others: list[Chain], *, is_complete: bool) -> bool:
    if chain == [(None, 0.0)]:
        return True  # the rest comes later
    return is_complete and all(_have_order(chain, other) for other in others)


def _have_order(one: Chain, two: Chain) -> bool:
    """Whether it is known which comes first."""
    for (occasion, time_s), (other, other_s) in zip(one, two, strict=False):
        if occasion is not other:
            return False
        first, second = (time_s, other_s) if len(one) <= len(two) else (other_s, time_s)
    return len(one) == len(two) or first <= second
