# SPDX-License-Identifier: BSD-3-Clause
"""Judges programs in real time, as real_time.h does: a failure counts only if the machine did not stall."""
import threading
import time

LOOK_S = 0.005
STALL_S = 0.5 / 4.0  # telemetry is dead after 0.5 s, and passes through four processes
ATTEMPTS = 5
SKIPPED = 77  # ctest's SKIP_RETURN_CODE of these tests


class StallMeter:
    """Measures the longest time for which the machine keeps a runnable process waiting."""

    def __init__(self):
        self.longest_s = 0.0
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.look, daemon=True)

    def look(self):
        last = time.monotonic()
        while not self.ended.is_set():
            time.sleep(LOOK_S)
            now = time.monotonic()
            self.longest_s = max(self.longest_s, now - last - LOOK_S)
            last = now

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()


def judge_in_real_time(flight, meter=StallMeter):
    """Repeats a flight until one counts. `flight` raises SystemExit with the reason when it fails, and uses its own
    folder each time. @returns the exit code: 0, or SKIPPED if the machine stalled in each of the failed flights."""
    for _ in range(ATTEMPTS):
        with meter() as machine:
            try:
                flight()
                return 0
            except SystemExit as failure:
                reason = failure
        if machine.longest_s < STALL_S:
            raise reason
        print(f"{reason}; the machine stalled for {machine.longest_s:.2f} s, so the flight is repeated")
    print(f"skipped: the machine stalled in each of {ATTEMPTS} flights")
    return SKIPPED


def self_test():
    """A failure without a stall counts at once; one with a stall does not count, and does not hide a later failure."""
    class Stalling:
        left = 0

        def __enter__(self):
            self.longest_s = STALL_S if Stalling.left > 0 else 0.0
            Stalling.left -= 1
            return self

        def __exit__(self, *_):
            pass

    def judged(stalls, bad):
        flown = []

        def flight():
            flown.append(1)
            if len(flown) <= bad:
                raise SystemExit("it came down")
        Stalling.left = stalls
        try:
            return judge_in_real_time(flight, Stalling), len(flown)
        except SystemExit as failure:
            return str(failure), len(flown)

    wanted = {(0, 0): (0, 1), (0, 1): ("it came down", 1), (2, 2): (0, 3), (1, 0): (0, 1),
              (ATTEMPTS - 1, ATTEMPTS): ("it came down", ATTEMPTS), (ATTEMPTS, ATTEMPTS): (SKIPPED, ATTEMPTS)}
    for (stalls, bad), result in wanted.items():
        if judged(stalls, bad) != result:
            raise SystemExit(f"FAILED: {stalls} stalls, {bad} bad flights: {judged(stalls, bad)}, not {result}")


if __name__ == "__main__":
    self_test()
