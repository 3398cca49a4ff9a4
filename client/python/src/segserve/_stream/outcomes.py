# SPDX-License-Identifier: Apache-2.0
"""Outcomes as the application gets them."""
from __future__ import annotations

from segserve import result_message
from segserve.errors import Internal, Unimplemented
from segserve._stream.frame import Outcome, OutcomeKind, UndecodedOutcome


def decode_outcome(undecoded: UndecodedOutcome) -> Outcome:
    """Decodes the result. The outcome becomes FAILED with Internal if the server's result is broken."""
    outcome = undecoded.outcome
    if outcome.kind is not OutcomeKind.RESULT or undecoded.message is None:
        return outcome
    try:
        outcome.result = result_message.decode(undecoded.message, undecoded.shape, undecoded.outputs, outcome.request_id,
                                       outcome.frame_id, outcome.stamp, wants_tracks=undecoded.wants_tracks)
    except (Internal, Unimplemented) as error:
        outcome.kind, outcome.error = OutcomeKind.FAILED, error
    return outcome
