"""How many cranks a second a study draws and judges, in processor time of one core.

python benchmarks/study_speed.py JOB.toml [--samples 200000]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from autobalance.job import load
from autobalance.studies.study.causes import causes_of
from autobalance.studies.study.plan import planned
from autobalance.studies.study.statistics import LinearModel, state_of


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("job")
    parser.add_argument("--samples", type=int, default=200_000)
    given = parser.parse_args()
    plan = planned(load(Path(given.job)), lambda _: None)
    model = LinearModel(state_of(plan.result.residual), causes_of(plan).draws, plan.tolerance)
    since = time.process_time()
    drawn = {draw.label: draw.sampled(1, given.samples, "random") for draw in model.draws}
    within = float((model.used_shares(model.states(drawn)) <= 1.0).mean())
    seconds = time.process_time() - since
    print(
        f"{given.samples} cranks of {len(model.draws)} draws in {seconds:.2f} s: "
        f"{given.samples / seconds:.0f} a second; {100 * within:.2f} % within"
    )


if __name__ == "__main__":
    main()
