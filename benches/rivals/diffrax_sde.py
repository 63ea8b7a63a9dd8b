"""Euler, Heun and ShARK of diffrax on the problems of the chart `sde`: CPU time, steps, error with its standard error.

    python3 -m venv venv && venv/bin/pip install -r benches/rivals/requirements.txt
    venv/bin/python benches/rivals/diffrax_sde.py > tests/reference/derived/sde/diffrax.json

The chart draws the recorded output; it does not start Python. What is measured:

- Two problems, those of additive noise: the sine drift to t = 1, and the oscillator with viscous damper (Canor and
  Denoel 2013, eq 26, a = 1) from rest to t = 10.
- Fixed steps, double precision, one compiled call that maps over all paths (`jax.vmap`), on one thread.
- Noise by `VirtualBrownianTree`, whose path is the same at every step length, for the strong error: against ShARK with
  16 times finer steps (sine) or 4 times (damper).
- CPU time by `time.process_time` with `UnsafeBrownianPath`, the faster noise, for 500 paths; the median of five calls
  after compilation, and half their range. That flatters the rival: this noise cannot be refined.
"""

import os

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["OMP_NUM_THREADS"] = "1"
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})

import datetime
import json
import math
import platform
import statistics
import sys
import time
from importlib.metadata import version

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

TIMED_PATHS = 500
ERROR_PATHS = 512
BATCHES = 32


def sine_drift(t, y, args):
    return -jnp.sin(3.0 * y) - 0.2 * y


def sine_noise(t, y, args):
    return jnp.array(0.8)


def damper_drift(t, y, args):
    omega, xi, eta, alpha = jnp.pi, 0.01, 0.25, 0.35
    q, v = y[0], y[1]
    speed = jnp.abs(v)
    # A power of zero has a derivative that is not a number; none is taken here, but the value is guarded all the same.
    damping = 2 * xi * omega * v + eta * jnp.sign(v) * jnp.where(speed > 0, speed, 1.0) ** alpha * (speed > 0)
    return jnp.stack([v, -damping - omega**2 * q])


def damper_noise(t, y, args):
    return jnp.array([0.0, math.sqrt(2 * 0.2)])


PROBLEMS = {
    "sine": dict(drift=sine_drift, noise=sine_noise, start=jnp.array(1.0), end=1.0, steps=[4, 16, 64, 256], finer=16),
    "damper": dict(drift=damper_drift, noise=damper_noise, start=jnp.zeros(2), end=10.0, steps=[128, 512, 2048], finer=4),
}

METHODS = {"euler": diffrax.Euler, "heun": diffrax.Heun, "shark": diffrax.ShARK}


def solver(problem, method, n_steps, tree):
    """A compiled function from keys to the states at the end."""
    end = problem["end"]
    dt = end / n_steps
    area = diffrax.SpaceTimeLevyArea

    def one(key):
        if tree:
            path = diffrax.VirtualBrownianTree(0.0, end, tol=end / tree / 2, shape=(), key=key, levy_area=area)
        else:
            path = diffrax.UnsafeBrownianPath(shape=(), key=key, levy_area=area if method == "shark" else diffrax.BrownianIncrement)
        terms = diffrax.MultiTerm(diffrax.ODETerm(problem["drift"]), diffrax.ControlTerm(problem["noise"], path))
        solution = diffrax.diffeqsolve(
            terms, METHODS[method](), 0.0, end, dt, problem["start"],
            saveat=diffrax.SaveAt(t1=True), adjoint=diffrax.ForwardMode(),
            max_steps=n_steps + 8, stepsize_controller=diffrax.ConstantStepSize(),
        )
        return solution.ys[0]

    return jax.jit(jax.vmap(one))


def timed(problem, method, n_steps):
    run = solver(problem, method, n_steps, tree=0)
    keys = jax.random.split(jax.random.key(1), TIMED_PATHS)
    run(keys).block_until_ready()
    times = []
    for _ in range(5):
        start = time.process_time()
        run(keys).block_until_ready()
        times.append((time.process_time() - start) / TIMED_PATHS)
    return statistics.median(times), (max(times) - min(times)) / 2


def errors(problem, method, reference, keys, finest, n_steps):
    """Root mean square distance to the reference on the same paths, and its standard error by the jackknife."""
    states = np.asarray(solver(problem, method, n_steps, finest)(keys)).reshape(len(keys), -1)
    squares = ((states - reference) ** 2).sum(axis=1)
    finite = np.isfinite(squares)
    if not finite.all():
        return None, None
    batches = squares.reshape(BATCHES, -1).mean(axis=1)
    left = np.sqrt((batches.sum() - batches) / (BATCHES - 1))
    spread = math.sqrt((BATCHES - 1) / BATCHES * ((left - left.mean()) ** 2).sum())
    return float(math.sqrt(squares.mean())), spread


def processor():
    try:
        with open("/proc/cpuinfo") as file:
            return next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    except OSError:
        return platform.processor()


def main():
    rows = []
    for name, problem in PROBLEMS.items():
        finest = problem["steps"][-1] * problem["finer"]
        keys = jax.random.split(jax.random.key(2), ERROR_PATHS)
        reference = np.asarray(solver(problem, "shark", finest, finest)(keys)).reshape(ERROR_PATHS, -1)
        for method in METHODS:
            for n_steps in problem["steps"]:
                error, spread = errors(problem, method, reference, keys, finest, n_steps)
                seconds, scatter = timed(problem, method, n_steps)
                rows.append(dict(problem=name, method=method, steps=n_steps, cpu_seconds_per_path=seconds,
                                 cpu_seconds_scatter=scatter, strong_error=error, strong_error_se=spread))
                print(f"{name} {method} {n_steps}: {seconds * 1e6:.1f} us, error {error}", file=sys.stderr)
    packages = ["jax", "jaxlib", "diffrax", "equinox", "lineax", "numpy"]
    json.dump(dict(
        origin="benches/rivals/diffrax_sde.py: strong errors on 512 paths (jackknife over 32 batches), against ShARK of "
               "diffrax at finer steps; CPU time per path, 500 paths in one compiled call, median and half range of five",
        date=datetime.date.today().isoformat(),
        versions={package: version(package) for package in packages} | dict(python=platform.python_version()),
        machine=dict(processor=processor(), threads=1, load=os.getloadavg()[0]),
        paths=ERROR_PATHS, timed_paths=TIMED_PATHS, rows=rows,
    ), sys.stdout, indent=1)
    print()


main()
