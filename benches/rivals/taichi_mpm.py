"""MLS-MPM of taichi on the problem of the benchmark `smpm`: particle updates per CPU second, and ours beside them.

    python3.11 -m venv venv && venv/bin/pip install -r benches/rivals/requirements-taichi.txt
    cargo bench -p benches --bench smpm --no-run
    venv/bin/python benches/rivals/taichi_mpm.py target/release/deps/smpm-<hash>

taichi 1.7.4 has wheels on PyPI for Python 3.9 to 3.13, none for later ones. What is measured:

- The square of the benchmark: 160 000 particles, four to a cell of 1/200, the same velocities, E = 100, nu = 0.3, rho = 1,
  plane strain, the same step; quadratic B-splines, APIC in the form of MLS-MPM (Hu et al. 2018), as in taichi's own
  examples `mpm88` and `mpm99`. The stress is linear elastic in the small strain, of which taichi updates F alone. That is
  less work than ours: no rotation of the stress, no energy, no step limit, no checks.
- Particles in the order of a lattice, which flatters the rival: its examples start in random order.
- CPU time of the process (`time.process_time`) over 20 steps after compilation, the median of seven; in f32 and f64, on one
  thread and on two. taichi and the benchmark run one after the other, three times in turns; the ratio of each turn is ours
  over theirs.
- Without the path of the benchmark, theirs alone.
"""

import os
import re
import statistics
import subprocess
import sys
import time

WORKER = "--worker"
N_SIDE, STEPS = 400, 20
ROUNDS = 3


def worker(precision, threads):
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[:threads])
    import numpy as np
    import taichi as ti

    real = {"f32": ti.f32, "f64": ti.f64}[precision]
    ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=threads, log_level=ti.ERROR)
    n, n_grid = N_SIDE * N_SIDE, 256
    dx, dt = 2.0 / N_SIDE, 3.4e-4 * 0.5
    volume = (0.5 * dx) ** 2
    mass = volume
    mu = 100.0 / 2.6
    lam = 100.0 * 0.3 / (1.3 * 0.4)
    x, v = ti.Vector.field(2, real, n), ti.Vector.field(2, real, n)
    C, F = ti.Matrix.field(2, 2, real, n), ti.Matrix.field(2, 2, real, n)
    grid_v, grid_m = ti.Vector.field(2, real, (n_grid, n_grid)), ti.field(real, (n_grid, n_grid))

    @ti.kernel
    def clear():
        for i, j in grid_m:
            grid_v[i, j] = [0, 0]
            grid_m[i, j] = 0

    @ti.kernel
    def p2g():
        for p in x:
            base = (x[p] / dx - 0.5).cast(int)
            fx = x[p] / dx - base.cast(real)
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]
            F[p] = F[p] + dt * C[p] @ F[p]
            eps = 0.5 * (F[p] + F[p].transpose()) - ti.Matrix.identity(real, 2)
            stress = 2 * mu * eps + lam * eps.trace() * ti.Matrix.identity(real, 2)
            affine = -dt * volume * 4 / dx**2 * stress + mass * C[p]
            for i, j in ti.static(ti.ndrange(3, 3)):
                offset = ti.Vector([i, j])
                dpos = (offset.cast(real) - fx) * dx
                weight = w[i][0] * w[j][1]
                grid_v[base + offset] += weight * (mass * v[p] + affine @ dpos)
                grid_m[base + offset] += weight * mass

    @ti.kernel
    def grid():
        for i, j in grid_m:
            if grid_m[i, j] > 0:
                grid_v[i, j] /= grid_m[i, j]

    @ti.kernel
    def g2p():
        for p in x:
            base = (x[p] / dx - 0.5).cast(int)
            fx = x[p] / dx - base.cast(real)
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]
            new_v = ti.Vector.zero(real, 2)
            new_C = ti.Matrix.zero(real, 2, 2)
            for i, j in ti.static(ti.ndrange(3, 3)):
                dpos = ti.Vector([i, j]).cast(real) - fx
                weight = w[i][0] * w[j][1]
                g_v = grid_v[base + ti.Vector([i, j])]
                new_v += weight * g_v
                new_C += 4 * weight * g_v.outer_product(dpos) / dx
            v[p], C[p] = new_v, new_C
            x[p] += dt * v[p]

    along = (np.arange(N_SIDE) + 0.5) * 0.5 * dx
    points = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    s = 3.0 * (points - 0.5)
    speed = 0.1
    velocities = speed * np.stack([1 + np.sin(s[:, 0]) - s[:, 1], s[:, 0] - 0.5 * np.sin(s[:, 1])], axis=-1)
    kind = np.float32 if precision == "f32" else np.float64
    x.from_numpy((points + 0.1).astype(kind))
    v.from_numpy(velocities.astype(kind))
    F.from_numpy(np.broadcast_to(np.eye(2), (n, 2, 2)).astype(kind))

    def step():
        clear()
        p2g()
        grid()
        g2p()

    before = x.to_numpy().astype(float).mean(axis=0)
    step()
    ti.sync()
    rates, walls = [], []
    for _ in range(7):
        start, clock = time.process_time(), time.perf_counter()
        for _ in range(STEPS):
            step()
        ti.sync()
        rates.append(1e-6 * n * STEPS / (time.process_time() - start))
        walls.append(1e-6 * n * STEPS / (time.perf_counter() - clock))
    # Momentum is kept: the mean moves with the mean velocity.
    moved = x.to_numpy().astype(float).mean(axis=0) - before
    expected = velocities.mean(axis=0) * dt * (1 + 7 * STEPS)
    assert np.allclose(moved, expected, rtol=1e-2), (moved, expected)
    print(statistics.median(rates), statistics.median(walls))


def theirs(precision, threads):
    out = subprocess.run([sys.executable, __file__, WORKER, precision, str(threads)], capture_output=True, text=True)
    if out.returncode != 0:
        sys.exit(out.stderr)
    return [float(word) for word in out.stdout.split()[-2:]]


def ours(benchmark):
    """M updates per CPU second of quadratic APIC on one thread, in f64, from the table of ratios."""
    out = subprocess.run([benchmark, "quadratic APIC", "--bench"], capture_output=True, text=True).stdout
    return float(re.search(r"quadratic APIC\s*\|[^|]*\|\s*([0-9.]+)", out).group(1))


def main():
    if WORKER in sys.argv:
        at = sys.argv.index(WORKER)
        worker(sys.argv[at + 1], int(sys.argv[at + 2]))
        return
    benchmark = sys.argv[1] if len(sys.argv) > 1 else None
    from importlib.metadata import version

    print(f"taichi {version('taichi')}, Python {sys.version.split()[0]}, load {os.getloadavg()[0]:.1f}")
    print("| taichi | M updates per CPU second | wall | ours, f64, one thread | ours / theirs, target 2 |")
    print("|---|---|---|---|---|")
    for precision, threads in [("f32", 1), ("f64", 1), ("f32", 2), ("f64", 2)]:
        rows = []
        for _ in range(ROUNDS):
            rate, wall = theirs(precision, threads)
            rows.append((rate, wall, ours(benchmark) if benchmark else float("nan")))
        rate, wall, own = (statistics.median(column) for column in zip(*rows))
        ratios = sorted(own / rate for rate, _, own in rows)
        print(f"| {precision}, {threads} thread{'s' * (threads > 1)} | {rate:.1f} | {wall:.1f} | {own:.1f} | "
              f"{statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f}) |", flush=True)
    print(f"load {os.getloadavg()[0]:.1f} at the end")


main()
