# SPDX-License-Identifier: BSD-3-Clause
"""Whether the verdict of a measured flight depends on where the log is cut, and on which part trains the model.

Each flight is cut at nine places, and either part trains the model that the other one judges. The two answers of a cut
agree if their verdicts are equal and one set of effects is admitted by both: the named effects, or some of them with
what the answer itself calls not separable from them in their place."""
import itertools
import statistics

from measure.lab_figures import asked, table
from measure.split_figures import CLIMB, MAP, TILT, YAW
from measure.workspace import Source

SECOND = ("falcon2_height.csv", "falcon2.toml")
# Per flight: name, log, column map (None: the first aircraft's), axis, begin [s], middle [s], end [s].
FLIGHTS = (("roll", TILT, None, "roll", 12, 38, 55.5), ("pitch", TILT, None, "pitch", 12, 38, 55.5),
           ("climb", CLIMB, None, "climb", 4.5, 38, 64.5), ("yaw rate", YAW, None, "yaw_rate", 10, 30, 51),
           ("yaw rate, whole log", YAW, None, "yaw_rate", 0, 30, 61.3), ("second aircraft: roll", *SECOND, "roll", 33, 66, 99),
           ("second aircraft: pitch", *SECOND, "pitch", 33, 66, 99), ("second aircraft: climb", *SECOND, "climb", 33, 66, 99))
SHIFTS_S = range(-4, 5)  # of the boundary from the middle


def answers(workspace, flight):
    """-> for each cut, the answer trained on its first part and that trained on its second part"""
    _, log, columns, axis, begin, middle, end = flight
    words = ["--log", workspace.measured_log(log), "--columns", workspace.measured_log(columns) if columns else MAP, "--axis", axis]
    out = []
    for at in (middle + shift for shift in SHIFTS_S):
        parts = [f"{begin:g}:{at:g}", f"{at:g}:{end:g}"]
        out.append([asked(workspace, "identify", *words, "--declare", "first_order", "--train", train, "--validate", validate)[1]
                    for train, validate in (parts, parts[::-1])])
    return out


def named(answer):
    return frozenset([one["name"] for one in answer["effects"]] + ["change of " + one["name"] for one in answer["changes"]])


def admitted(answer):
    """-> every set of effects that the answer calls as good as the one that it names; a rival may be two effects, "a + b" """
    fixed = frozenset("change of " + one["name"] for one in answer["changes"])
    choices = [[one["name"], *(rival["name"] for rival in one["rivals"])] for one in answer["effects"]]
    return {fixed.union(*(choice.split(" + ") for choice in chosen)) for chosen in itertools.product(*choices)}


def spread(values, digits):
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def row(name, cuts):
    """-> the counts and the row of one flight"""
    both = [answer for pair in cuts for answer in pair]
    declared, final = ([one[model]["validation_rmse"] for one in both] for model in ("declared", "final"))
    explained = [100 * (1 - (after / before) ** 2) for before, after in zip(declared, final)]
    verdicts = [first["verdict"] == second["verdict"] for first, second in cuts]
    literal = [same and named(first) == named(second) for same, (first, second) in zip(verdicts, cuts)]
    agree = [same and bool(admitted(first) & admitted(second)) for same, (first, second) in zip(verdicts, cuts)]
    counts = [sum(verdicts), sum(literal), sum(agree), len(cuts)]
    words = [f"{sum(one['verdict'] == verdict for one in both)}" for verdict in ("explained", "unexplained", "nothing_missing")]
    effects = sorted({effect for one in both for effect in named(one)})
    often = [f"{effect.replace('_', ' ')} {sum(effect in named(one) for one in both)}" for effect in effects]
    return counts, [name, "/".join(words), f"{counts[0]}", f"{counts[2]} ({counts[1]})", f"{sum(bool(named(one)) for one in both)}",
                    ", ".join(often), spread(declared, 4), spread(final, 4), spread(explained, 0)]


def cuts_table(all_answers):
    """@param all_answers  {name of the flight: answers()}"""
    rows = [["flight (9 cuts, 18 answers)", "explained/unexplained/nothing missing", "verdict agrees", "effects too (literally)", "answers with a name",
             "named", "declared: median (range)", "with the effects", "share explained [%]"]]
    total = [0, 0, 0, 0]
    for name, cuts in all_answers.items():
        counts, cells = row(name, cuts)
        total = [a + b for a, b in zip(total, counts)]
        rows.append(cells)
    rows.append(["together", "", f"{total[0]} of {total[3]}", f"{total[2]} ({total[1]})", "", "", "", "", ""])
    return table(*rows)


def cuts(workspace):
    """Verdicts, effects and errors of every measured flight, cut at nine places, both ways."""
    return {"identify.cuts": cuts_table({flight[0]: answers(workspace, flight) for flight in FLIGHTS})}


SOURCES = [Source(("identify.cuts",), cuts, quick=False)]
