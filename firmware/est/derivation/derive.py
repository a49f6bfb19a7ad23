#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Derives the discrete model of a horizontal axis, as the observer and the MPC's predictor fly it, from the equations of the paper.

Usage: derive.py                      prints the model, its discretisation and the Jacobians
       derive.py --compare PROGRAM    compares the coefficients that PROGRAM prints as JSON; exits with 1 if one is off
       derive.py --self-test PROGRAM  plants an error in each of these numbers and sees it noticed

States of the observer: p [m], v [m/s], t tilt [rad], r tilt rate [rad/s], d disturbance [m/s^2], m input offset [rad]; u is the command
that acts, T the tick. Needs python3-sympy.
"""
import json
import subprocess
import sys

import mpmath
import sympy as sp

mpmath.mp.dps = 40
TOLERANCE = 1e-12  # relative to the largest number of its matrix: rounding of some dozen operations in double

T, w, z, tau, L, g, c, c2 = sp.symbols("T omega zeta tau L g c c_2", positive=True)
p, v, t, r, d, m, u = sp.symbols("p v t r d m u", real=True)
speed, a = sp.symbols("|v| a", real=True)  # a: age of a measurement
STATES = [p, v, t, r, d, m]

# ---- The model in continuous time.
# Attitude loop (paper, III-D.2 and Table II): t'' = w^2 (u + L u' + m - t) - 2 z w t', or t' = (u + L u' + m - t) / tau.
SECOND_ORDER = sp.Matrix([[0, 1], [-w**2, -2 * z * w]])
SECOND_ORDER_INPUT = sp.Matrix([0, w**2])
# Translation (paper, III-C): p' = v, v' = g tan t - c v - c2 |v| v + d; d' = 0 (paper, Eq. (2)); m' = 0.


def second_order_transition():
    """exp(A T) by Cayley and Hamilton: f0 I + f1 A. Checked against its definition, E' = A E, E(0) = I."""
    wd = w * sp.sqrt(1 - z**2)
    f1 = sp.exp(-z * w * T) * sp.sin(wd * T) / wd
    f0 = sp.exp(-z * w * T) * (sp.cos(wd * T) + z * w * sp.sin(wd * T) / wd)
    e = f0 * sp.eye(2) + f1 * SECOND_ORDER
    assert sp.simplify(e.diff(T) - SECOND_ORDER * e) == sp.zeros(2) and e.subs(T, 0) == sp.eye(2)
    return e


def attitude_step(first_order):
    """Coefficients of model::AxisStep: of t, r, held input, and a jump of the input at the beginning of the step."""
    if first_order:
        decay = sp.exp(-T / tau)
        jump = decay * L / tau  # L u' of a jump adds L / tau of it to the output
        return {"oo": decay, "o_r": 0, "o_u": 1 - decay, "o_jump": jump,
                # The rate is no state: the right-hand side at the end of the step, with the input of the next one.
                "ro": -decay / tau, "rr": 0, "r_u": -(1 - decay) / tau, "r_next": 1 / tau, "r_jump": -jump / tau}
    e = second_order_transition()
    held = (e - sp.eye(2)) * SECOND_ORDER.inv() * SECOND_ORDER_INPUT  # integral of exp(A s) B over the step
    jump = e * SECOND_ORDER_INPUT * L                                 # L u' of a jump adds w^2 L of it to the rate
    return {"oo": e[0, 0], "o_r": e[0, 1], "o_u": held[0], "o_jump": jump[0],
            "ro": e[1, 0], "rr": e[1, 1], "r_u": held[1], "r_next": 0, "r_jump": jump[1]}


OO, O_R, O_U, RO, RR, R_M = sp.symbols("oo o_r o_u ro rr r_m", real=True)


def prediction():
    """The observer's step. The acceleration is that at the middle of the tick: g tan t at its beginning, and half of the tick's
    change of tilt by the slope g / cos^2 t."""
    tilt = OO * t + O_R * r + O_U * (u + m)
    rate = RO * t + RR * r + R_M * (u + m)
    acceleration = g * sp.tan(t) + g / 2 / sp.cos(t)**2 * (tilt - t) - c * v - c2 * speed * v + d
    return sp.Matrix([p + T * v + T**2 / 2 * acceleration, v + T * acceleration, tilt, rate, d, m])


def jacobian():
    """-> (exact Jacobian of prediction(), the one that flies, {(row, column): what it leaves out})."""
    step = prediction()
    exact = step.jacobian(STATES)
    for row in range(2):  # d(|v| v)/dv = 2 |v|
        exact[row, 1] += step[row].diff(speed) * v / speed
        exact[row, 1] = sp.simplify(exact[row, 1].subs(v, speed))
    bend = g / sp.cos(t)**2 * sp.tan(t) * (step[2] - t)  # the slope's own change; below 2 % of it in a tick at 10 rad/s
    left_out = {(0, 2): T**2 / 2 * bend, (1, 2): T * bend}
    flown = exact.copy()
    for (row, column), what in left_out.items():
        flown[row, column] = sp.simplify(exact[row, column] - what)
    assert not flown[1, 2].has(u)
    return exact, flown, left_out


def measurements():
    """Measured `a` ago: position, tilt and tilt rate, each as a row of the Jacobian. The acceleration since then comes from the history
    of the filter, so the position depends on v and d only."""
    back = sp.Matrix([p - a * v + a**2 / 2 * d, t - a * r, r])
    return back.jacobian(STATES)


def predictor(first_order):
    """-> (F, G, Gd) of the MPC's predictor, g the signed acceleration per tilt; first order: chi, t = (1 - L/tau) chi + L/tau u."""
    if first_order:
        share = L / tau
        return (sp.Matrix([[0, 1, 0], [0, -c, g * (1 - share)], [0, 0, -1 / tau]]), sp.Matrix([0, g * share, 1 / tau]),
                sp.Matrix([0, 1, 0]))
    return (sp.Matrix([[0, 1, 0, 0], [0, -c, g, g * L], [0, 0, 0, 1], [0, 0, -w**2, -2 * z * w]]), sp.Matrix([0, 0, 0, w**2]),
            sp.Matrix([0, 1, 0, 0]))


def number(expression, values):
    return mpmath.mpf(1) * sp.N(sp.sympify(expression).subs(values), 40).as_real_imag()[0]


def numbers(matrix, values):
    return mpmath.matrix([[number(matrix[i, j], values) for j in range(matrix.cols)] for i in range(matrix.rows)])


def discretised(first_order, values):
    """exp of the augmented matrix: inputs held over the step, exact."""
    f, b, bd = predictor(first_order)
    n = f.rows
    whole = sp.zeros(n + 2)
    whole[:n, :n], whole[:n, n], whole[:n, n + 1] = f, b, bd
    augmented = mpmath.expm(numbers(whole, values) * mpmath.mpf(values[T]))
    rows = [[augmented[i, j] for j in range(n + 2)] for i in range(n)]
    return {"a": [row[:n] for row in rows], "b": [row[n] for row in rows], "bd": [row[n + 1] for row in rows]}


def values_of(case):
    exact = {key: sp.Rational(value) for key, value in case.items() if isinstance(value, (int, float))}
    return {T: exact["step_s"], w: exact["frequency"], z: exact["damping"], tau: exact["time_constant"], L: exact["lead_zero"],
            g: exact.get("gravity", 0), c: exact.get("drag", 0), c2: exact.get("drag2", 0)}


def flat(value):
    return [number for part in value for number in flat(part)] if isinstance(value, (list, tuple)) else [value]


def differences(flown):
    """-> [(which, largest difference over the largest number)] of all that flies."""
    out = []

    def compare(which, derived, flies):
        derived, flies = flat(derived), flat(flies)
        assert len(derived) == len(flies), which
        size = max(abs(number) for number in derived)
        out.append((which, float(max(abs(x - mpmath.mpf(y)) for x, y in zip(derived, flies)) / size)))

    for case in flown["axis_step"]:
        step = attitude_step(case["time_constant"] > 0)
        values = values_of(case)
        for name in step:
            compare(f"axis_step {case['name']} {name}", [number(step[name], values), mpmath.mpf(1)], [case[name], 1.0])
    for case in flown["predictor"]:
        derived = discretised(case["time_constant"] > 0, values_of(case))
        for name in derived:
            compare(f"predictor {case['name']} {name}", derived[name], case[name])
    for case in flown["observer"]:
        compare_observer(case, compare)
    return out


def compare_observer(case, compare):
    """One prediction from a diagonal covariance, and one measurement of each kind: state, covariance and innovation variances."""
    values = values_of(case)
    step = attitude_step(case["time_constant"] > 0)
    at = {**values, **dict(zip(STATES, map(sp.Rational, case["state"]))), u: sp.Rational(case["command"])}
    at[speed] = abs(at[v])
    at.update({OO: step["oo"].subs(values), O_R: sp.sympify(step["o_r"]).subs(values), O_U: step["o_u"].subs(values),
               RO: step["ro"].subs(values), RR: sp.sympify(step["rr"]).subs(values),
               R_M: sp.sympify(step["r_u"] + step["r_next"]).subs(values)})
    order = [OO, O_R, O_U, RO, RR, R_M]
    coefficients = {symbol: sp.Float(number(at[symbol], {}), 40) for symbol in order}
    at.update(coefficients)
    compare(f"observer {case['name']} state", [number(line, at) for line in prediction()], case["predicted"])
    phi = numbers(jacobian()[1], at)
    before = mpmath.diag([mpmath.mpf(x) for x in case["covariance"]])
    after = phi * before * phi.T + mpmath.diag([mpmath.mpf(x) for x in case["process"]])
    for i in range(6):
        for j in range(6):
            scale = mpmath.sqrt(after[i, i] * after[j, j])
            compare(f"observer {case['name']} covariance {i}{j}", [after[i, j] / scale, mpmath.mpf(1)],
                    [mpmath.mpf(case["predicted_covariance"][i][j]) / scale, 1.0])
    rows = numbers(measurements(), {a: sp.Rational(case["age_s"])})
    expected = rows[0, :] * after * rows[0, :].T
    compare(f"observer {case['name']} innovation variance", [expected[0] + mpmath.mpf(case["pose_variance"])],
            [case["innovation_variance"]])


def show():
    for title, first_order in (("second order", False), ("first order", True)):
        print(f"attitude, {title}:")
        for name, expression in attitude_step(first_order).items():
            print(f"  {name:7} = {sp.simplify(expression)}")
        f, b, bd = predictor(first_order)
        print(f"predictor, {title}: F = {f.tolist()}, G = {list(b)}, Gd = {list(bd)}; [A B Bd; 0 I] = exp([F G Gd; 0 0] T)")
    print("observer: x+ =")
    for state, line in zip(STATES, prediction()):
        print(f"  {state}+ = {line}")
    exact, flown, left_out = jacobian()
    print("Jacobian of the prediction, as it flies:")
    for row in range(6):
        print(f"  d{STATES[row]}+ : {flown[row, :].tolist()[0]}")
    for (row, column), what in left_out.items():
        print(f"  left out of d{STATES[row]}+/d{STATES[column]}: {what}")
    print("Jacobian of what is measured `a` ago (position, tilt, tilt rate):", measurements().tolist())


def main():
    if len(sys.argv) == 1:
        show()
        return 0
    flown = json.loads(subprocess.run([sys.argv[2]], capture_output=True, text=True, check=True).stdout)
    if sys.argv[1] == "--self-test":
        missed = []
        for kind, key in (("axis_step", "o_u"), ("predictor", "b"), ("observer", "predicted"), ("observer", "predicted_covariance"),
                          ("observer", "innovation_variance")):
            planted = json.loads(json.dumps(flown))
            value = planted[kind][0][key]
            if key == "predicted_covariance":
                value[1][2] *= 1.0 + 1e-10
            elif isinstance(value, list):
                value[1] += 1e-9 * max(map(abs, value))
            else:
                planted[kind][0][key] = value * (1.0 + 1e-9)
            planted = {name: planted[name][:1] if name == kind else [] for name in planted}
            if all(difference <= TOLERANCE for _, difference in differences(planted)):
                missed.append(f"{kind} {key}")
        print("missed:", missed)
        return 1 if missed else 0
    found = differences(flown)
    worst = max(found, key=lambda item: item[1])
    for which, difference in found:
        if difference > TOLERANCE:
            print(f"{which}: {difference:.1e} from its derivation")
    print(f"{len(found)} comparisons; the largest difference is {worst[1]:.1e} ({worst[0]}), {TOLERANCE:.0e} is allowed")
    return 1 if worst[1] > TOLERANCE else 0


if __name__ == "__main__":
    sys.exit(main())
