"""Seconds for all boundary curves of a plane on one core, and points per second of tracing alone.

The starts are every event of 200 rows of 400 columns; their sweep is timed apart, it is not part of the boundaries.
"""

import os
import statistics
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")


from pipeline.config.compose import compose
from pipeline.plan.numerics import model_at
from pipeline.plan.planning import plan
from solver import sweep_row
from solver.boundaries import boundary_curves, row_events

REPEAT = 9
PLANES = ("omega_b", "omega_alpha", "omega_fe", "omega_fpm")


def main() -> None:
    print(
        f"{'gear':12s} {'plane':14s} {'starts':>7s} {'curves':>7s} {'points':>7s} {'sweep s':>8s} {'all ms':>8s} "
        f"{'trace ms':>9s} {'points/s':>9s}"
    )
    for gear in ("published", "consistent", "antiphase"):
        for plane in PLANES:
            planned = plan(compose([f"gear={gear}", f"plane={plane}"]))
            x, p, axis = planned.sweep.values, planned.parameter.values, planned.parameter.name
            model = model_at(planned, float(p[0]), float(x[0]))
            begin = time.process_time()
            starts = [
                e for v in p for e in row_events(sweep_row(model.replace(**{axis: v}), "omega", x).curves, float(v))
            ]
            sweeping = time.process_time() - begin
            limits = ((x[0], x[-1]), (p[0], p[-1]))
            curves = boundary_curves(model, "omega", axis, *limits, starts)
            # One start per boundary leaves the tracing; what all the others cost is finding that they are known.
            few = [(c.kind, c.points[len(c.points) // 2]) for c in curves]
            whole, alone = [], []
            for _ in range(REPEAT):
                for given, times in ((starts, whole), (few, alone)):
                    begin = time.process_time()
                    result = boundary_curves(model, "omega", axis, *limits, given)
                    times.append(time.process_time() - begin)
            points = sum(len(c.points) for c in result)
            print(
                f"{gear:12s} omega x {axis:6s} {len(starts):7d} {len(curves):7d} {points:7d} {sweeping:8.2f} "
                f"{1e3 * statistics.median(whole):8.1f} {1e3 * statistics.median(alone):9.1f} "
                f"{points / statistics.median(alone):9.0f}"
            )


if __name__ == "__main__":
    main()
