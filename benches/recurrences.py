# Other solvers on the set of recurrences: one line "solver place right|wrong seconds" for each.
import re
import shutil
import signal
import subprocess
import sys
import time
from fractions import Fraction

LIMIT = 20
# Maxima's clock goes by hundredths of a second.
REPEATS = 10


class Late(Exception):
    pass


def late(*_):
    raise Late()


signal.signal(signal.SIGALRM, late)


def stanzas():
    """The forms, then the arrivals, each with whether it is one."""
    parts = [part for name in ("sixty", "arrivals") for part in open(f"@FOLDER@{name}.txt").read().split("\n\n")]
    parts = [part for part in parts if "solve " in part]
    return [(part, False) for part in parts if "terms " in part] + [(part, True) for part in parts if "find " in part]


def lines(stanza, word):
    return [line[len(word):] for line in stanza.splitlines() if line.startswith(word)]


def split(text):
    parts, depth, last = [], 0, 0
    for place, letter in enumerate(text):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            parts.append(text[last:place].strip())
            last = place + 1
    return parts + [text[last:].strip()]


def read(stanza):
    """Equations, first values, terms; None for what no other solver's input can say."""
    text = lines(stanza, "solve ")[0]
    steps, starts = {}, {}
    for equation in split(text):
        left, right = equation.split(" = ", 1)
        name, at = re.fullmatch(r"(\w+)\((.*)\)", left).groups()
        if "n" in at:
            steps[name] = (int(at.replace("n+", "")), right)
        else:
            starts.setdefault(name, {})[int(at)] = right
    terms = {}
    for line in lines(stanza, "terms "):
        name, values = line.split(": ", 1)
        terms[name] = values.split(", ")
    hard = any(word in text for word in ("clamp", "if ", "max", "mod"))
    return steps, starts, terms, hard


def first_index(sympy, found, n, goal, first, scope):
    """The least index of a form at which the goal holds, tried up to 500."""
    relation = re.search(r"<=|>=|<|>|=", goal).group(0)
    left, right = (re.sub(r"(\w+)\(n\)", r"\1", side) for side in goal.split(relation, 1))
    compare = {"<=": lambda a: a <= 0, ">=": lambda a: a >= 0, "<": lambda a: a < 0, ">": lambda a: a > 0, "=": lambda a: a == 0}
    for at in range(first, 500):
        values = {name: sympy.simplify(form.subs(n, at)) for name, form in found.items()}
        scope = {"abs": sympy.Abs, "max": sympy.Max, "norm": lambda v: sympy.sqrt(sum(x * x for x in v)), **values}
        difference = sympy.simplify(sympy.sympify(left, locals=scope, rational=True) - sympy.sympify(right, locals=scope, rational=True))
        if compare[relation](difference):
            return f"n = {at}"
    return None


def with_sympy(place, stanza, arrival):
    import sympy

    steps, starts, terms, hard = read(stanza)
    if hard:
        raise ValueError("by pieces")
    n = sympy.Symbol("n", integer=True, nonnegative=True)
    symbols = {name: sympy.Symbol(name) for name in "abcdpvg"}
    functions = {name: sympy.Function(name) for name in steps}
    scope = dict(symbols, n=n, **functions)

    def parse(text):
        return sympy.sympify(text.replace("^", "**"), locals=scope, rational=True)

    first = min(min(values) for values in starts.values())
    wanted = {name: [parse(term) for term in row] for name, row in terms.items()}
    started = time.perf_counter()
    if len(steps) == 1:
        (name, (offset, right)), = steps.items()
        y = functions[name]
        initial = {y(at): parse(text) for at, text in starts[name].items()}
        found = {name: sympy.rsolve(y(n + offset) - parse(right), y(n), initial)}
        if found[name] is None:
            raise ValueError("no form")
    else:
        names = list(steps)
        states = [functions[name](n) for name in names]
        rights = [sympy.expand(parse(steps[name][1])) for name in names]
        matrix = sympy.Matrix([[right.coeff(state) for state in states] for right in rights])
        rest = sympy.Matrix(rights) - matrix * sympy.Matrix(states)
        rest = rest.applyfunc(sympy.simplify)
        if any(entry.has(n) for entry in rest):
            raise ValueError("an input that depends on n")
        size = len(names)
        whole = sympy.zeros(size + 1, size + 1)
        whole[:size, :size], whole[:size, size], whole[size, size] = matrix, rest, 1
        start = sympy.Matrix([parse(starts[name][first]) for name in names] + [1])
        power = whole**n * start
        found = {name: power[row] for row, name in enumerate(names)}
    if arrival:
        goal, expected = lines(stanza, "find ")[0].split(" -> ")
        answer = first_index(sympy, found, n, goal, first, scope)
        # Terms that do not fit say nothing of those that were not tried.
        return answer is not None and answer == expected, time.perf_counter() - started
    seconds = time.perf_counter() - started
    for name, row in wanted.items():
        for at, term in enumerate(row):
            value = found[name].subs(n, at + first)
            if sympy.simplify(value - term) != 0:
                return False, seconds
    return True, seconds


def check(solver, run):
    for place, (stanza, arrival) in enumerate(stanzas()):
        signal.alarm(LIMIT)
        try:
            right, seconds = run(place, stanza, arrival)
            print(solver, place, "right" if right else "wrong", seconds)
        except Late:
            print(solver, place, "wrong", LIMIT)
        except Exception:
            print(solver, place, "wrong", 0)
        finally:
            signal.alarm(0)
        sys.stdout.flush()


def far():
    import sympy
    from sympy.polys.matrices import DomainMatrix

    rows = [[Fraction((row * 5 + column * 3) % 7 - 3, 2) for column in range(6)] for row in range(6)]
    matrix = DomainMatrix.from_Matrix(sympy.Matrix([[sympy.Rational(v.numerator, v.denominator) for v in row] for row in rows]))
    for at in (10_000, 100_000):
        signal.alarm(120)
        try:
            started = time.perf_counter()
            matrix**at
            print(f"sympy: the power {at} of the matrix of six by six in {time.perf_counter() - started:.3f} s")
        except Late:
            print(f"sympy: the power {at} of the matrix of six by six takes more than 120 s")
        finally:
            signal.alarm(0)


def maxima_input(steps, starts):
    (name, (offset, right)), = steps.items()
    equation = f"{name}(n+{offset})={right}"
    equation = re.sub(rf"\b{name}\(([^)]*)\)", rf"{name}[\1]", equation)
    initial = ",".join(f"{name}[{at}]={text}" for at, text in starts[name].items())
    return name, equation, initial


def with_maxima(place, stanza, arrival):
    steps, starts, terms, hard = read(stanza)
    if hard or arrival or len(steps) != 1:
        raise ValueError("not for solve_rec")
    name, equation, initial = maxima_input(steps, starts)
    first = min(starts[name])
    tests = ",".join(
        f"is(equal(ratsimp(radcan(expand(ev(rhs(s),n={at + first}))))-({term}),0))"
        for at, term in enumerate(terms[name])
    )
    program = (
        "display2d:false$ load(solve_rec)$ declare(n,integer)$ assume(n>=0)$ "
        f"t0:elapsed_run_time()$ for i:1 thru {REPEATS} do s:solve_rec({equation},{name}[n],{initial})$ t1:elapsed_run_time()$ "
        f"print(\"TIME\",(t1-t0)/{REPEATS}.0)$ print(\"RIGHT\",every(lambda([u],u=true),[{tests}]))$"
    )
    output = subprocess.run(["maxima", "--very-quiet"], input=program, capture_output=True, text=True, timeout=LIMIT).stdout
    seconds = float(re.search(r"TIME\s+([0-9.e+-]+)", output).group(1))
    return re.search(r"RIGHT\s+true", output) is not None, seconds


def with_giac(place, stanza, arrival):
    steps, starts, terms, hard = read(stanza)
    if hard or arrival or len(steps) != 1:
        raise ValueError("not for rsolve")
    (name, (offset, right)), = steps.items()
    first = min(starts[name])
    initial = ",".join(f"{name}({at})={text}" for at, text in starts[name].items())
    tests = ",".join(f"simplify(subst(s,n={at + first})-({term}))" for at, term in enumerate(terms[name]))
    program = (
        f"t:=time(s:=rsolve({name}(n+{offset})={right},{name}(n),[{initial}]));s:=s[0];print(\"TIME\",t[0]);print(\"TERMS\",[{tests}]);"
    )
    ran = subprocess.run(["giac"], input=program, capture_output=True, text=True, timeout=LIMIT)
    # What is printed begins a line; the input is echoed as well.
    output = ran.stdout + "\n" + ran.stderr
    seconds = float(re.search(r"^TIME,([0-9.e+-]+)", output, re.MULTILINE).group(1))
    terms = re.search(r"^TERMS,\[([^\]]*)\]", output, re.MULTILINE)
    return terms is not None and set(terms.group(1).split(",")) == {"0"}, seconds


for solver, run in (("giac", with_giac), ("maxima", with_maxima)):
    if shutil.which(solver):
        check(solver, run)
    else:
        print(f"{solver}: not installed")
try:
    import sympy
except ImportError:
    print("sympy: not installed")
else:
    check("sympy", with_sympy)
    far()
