"""The stop policy for leftover processes."""

import signal

import pytest

from launcher.base.model.spec import StopPolicy
from launcher.run.ending.leftovers import stop_policy_for

INT, TERM, HUP = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
KILLED = StopPolicy(polite=())


@pytest.mark.parametrize(
    ("policies", "polite"),
    [
        ([], ((INT, 1.0), (TERM, 5.0))),
        ([StopPolicy()], ((INT, 1.0), (TERM, 5.0))),
        ([StopPolicy(sigterm_timeout_s=60.0, sigkill_timeout_s=60.0)], ((INT, 1.0), (TERM, 5.0))),
        ([StopPolicy(sigterm_timeout_s=0.2, sigkill_timeout_s=0.3)], ((INT, 0.2), (TERM, 0.3))),
        ([KILLED], ()),
        ([KILLED, StopPolicy(sigterm_timeout_s=0.5), KILLED], ((INT, 0.5), (TERM, 5.0))),
        ([StopPolicy(polite=((HUP, 2.0), (TERM, 9.0)))], ((HUP, 2.0), (TERM, 5.0))),
    ],
)
def test_each_grace_period_is_the_longest_of_any_process_within_limits(policies, polite):
    assert stop_policy_for(policies).steps[:-1] == polite
