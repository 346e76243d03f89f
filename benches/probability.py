"""The noisy waypoint by others: dense quadrature and Monte Carlo in numpy, Storm on a discretised chain. One line each:
seconds, value. Prints `missing NAME` where something is not installed."""
import math
import sys
import time

try:
    import numpy as np
    from numpy.polynomial.legendre import leggauss
except ImportError:
    print("missing numpy")
    sys.exit()
try:
    from scipy.special import ndtr as cdf
except ImportError:
    erf = np.vectorize(math.erf, otypes=[float])
    def cdf(x):
        return 0.5 * (1 + erf(x / math.sqrt(2)))

NEXT = math.sqrt(.0101)
FOLLOWS = -.001 / .0101
REST = math.sqrt(.01 - .001 ** 2 / .0101)

def kernel(rows, x):
    """The density of the next position, and the chance of the look having been near, given both."""
    d = x[None, :] - (.9 * rows[:, None] + 1)
    near = np.exp(-d * d / (2 * NEXT * NEXT)) / (NEXT * math.sqrt(2 * math.pi))
    mean = rows[:, None] + FOLLOWS * d
    stop = np.zeros_like(mean)
    at = np.abs(mean - 10) < 1.1
    stop[at] = cdf((10.1 - mean[at]) / REST) - cdf((9.9 - mean[at]) / REST)
    return near, stop

def points(n):
    x, w = leggauss(n)
    return 13 / 2 * x + 11 / 2, w * 13 / 2

def done(x):
    return cdf((10.1 - x) / .1) - cdf((9.9 - x) / .1)

def line(n, looks):
    x, w = points(n)
    near, stop = kernel(x, x)
    step, end = near * (1 - stop) * w[None, :], done(x)
    v = np.zeros(n)
    for _ in range(looks - 1):
        v = end + step @ v
    near, stop = kernel(np.zeros(1), x)
    return float(((near * (1 - stop) * w[None, :]) @ v)[0])

def plane(n, looks):
    x, w = points(n)
    near, stop = kernel(x, x)
    whole, cut = near * w[None, :], near * stop * w[None, :]
    end = np.outer(done(x), done(x))
    v = np.zeros((n, n))
    for _ in range(looks - 1):
        v = end + whole @ v @ whole.T - cut @ v @ cut.T
    near, stop = kernel(np.zeros(1), x)
    whole, cut = near * w[None, :], near * stop * w[None, :]
    return float((whole @ v @ whole.T - cut @ v @ cut.T)[0, 0])

def monte_carlo(runs, looks, axes):
    rng = np.random.default_rng(1)
    r = np.zeros((runs, axes))
    total = runs
    reached = 0
    for _ in range(looks):
        m = r + rng.normal(0, .1, r.shape)
        near = (np.abs(m - 10) <= .1).all(axis=1)
        reached += int(near.sum())
        r, m = r[~near], m[~near]
        r = r + ((10 - m) / 2 + rng.normal(0, .5, r.shape)) / 5
    return reached / total

def steps(runs, rounds):
    rng = np.random.default_rng(1)
    r = np.zeros(runs)
    for _ in range(rounds):
        m = r + rng.normal(0, .1, runs)
        r += ((10 - m) / 2 + rng.normal(0, .5, runs)) / 5
    return float(np.mean(np.abs(r - 10) <= .1))

def storm(n, looks):
    try:
        import stormpy
    except ImportError:
        print("missing stormpy")
        sys.exit()
    start = time.perf_counter()
    width = 13 / n
    first = round(1 / width)
    # The start is the middle of a cell.
    x = width * (np.arange(n) - first)
    near, stop = kernel(x, x)
    step = near * (1 - stop) * width
    builder = stormpy.datastructures.SparseMatrixBuilder(rows=n + 2, columns=n + 2, entries=0, force_dimensions=False)
    end = done(x)
    for row in range(n):
        places = np.nonzero(step[row] > 1e-12)[0]
        rest = 1 - end[row] - step[row, places].sum()
        for place in places:
            builder.add_next_value(row, int(place), float(step[row, place]))
        builder.add_next_value(row, n, float(end[row]))
        builder.add_next_value(row, n + 1, float(max(rest, 0)))
    builder.add_next_value(n, n, 1.0)
    builder.add_next_value(n + 1, n + 1, 1.0)
    labels = stormpy.models.StateLabeling(n + 2)
    labels.add_label("init")
    labels.add_label("done")
    labels.add_label_to_state("init", first)
    labels.add_label_to_state("done", n)
    model = stormpy.models.SparseDtmc(stormpy.models.SparseModelComponents(builder.build(), labels))
    asked = stormpy.parse_properties(f'P=? [F<={looks} "done"]')
    check = time.perf_counter()
    value = stormpy.model_checking(model, asked[0]).get_value(first)
    end = time.perf_counter()
    return end - start, value, end - check

what, size, looks, times = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
best, value, check = float("inf"), None, 0.0
for _ in range(times):
    start = time.perf_counter()
    if what == "storm":
        seconds, value, check = storm(size, looks)
    else:
        work = {"line": line, "plane": plane, "steps": steps}
        if what in work:
            value = work[what](size, looks)
        else:
            value = monte_carlo(size, looks, 2 if what == "runs2" else 1)
        seconds = time.perf_counter() - start
    best = min(best, seconds)
print(best, value, check)
