# SPDX-License-Identifier: Apache-2.0
"""Streams frames to whichever of several servers is in reach, and uses the newest results.

    python3 example_stream.py ADDRESS [FRAMES]

A camera hands over frames faster than they may be segmented: old ones make way, and results that would come later than
half a second are of no use.
"""
import sys
import threading
import time

import numpy as np

import segserve


def camera(count):
    """Frames of a box on a table, 160 x 120 pixels, 30 a second, as (xyz, rgb)."""
    y, x = np.mgrid[-60:60, -80:80] / 131.25
    for number in range(count):
        is_box = (abs(x - number / 200) < 0.15) & (abs(y) < 0.15)
        z = np.where(is_box, 0.8, 1.0)
        rgb = np.where(is_box[..., None], (200, 60, 40), (180, 180, 170)).astype(np.uint8)
        yield np.stack([x * z, y * z, z], axis=-1), rgb
        time.sleep(1 / 30)


def main():
    address, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 30
    with segserve.Client(address) as client:
        with client.stream(view="camera", when_behind="drop_oldest", max_in_flight=2,
                           outputs=("labels", "segments")) as stream:

            def send():
                for xyz, rgb in camera(count):
                    stream.send(xyz, rgb, frame_id="camera", time_to_live=0.5)
                stream.finish()

            threading.Thread(target=send).start()
            for outcome in stream:
                if outcome.result is None:
                    print(f"frame {outcome.sequence}: {outcome.kind.value}, {outcome.error}")
                else:
                    age = outcome.report.outcome_done - outcome.report.handed_over
                    print(
                        f"frame {outcome.sequence}: {outcome.result.segment_count} segments after {1000 * age:.0f} ms")


main()
