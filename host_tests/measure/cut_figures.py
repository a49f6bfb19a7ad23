# SPDX-License-Identifier: BSD-3-Clause
"""Whether the verdict of a measured flight depends on where the log is cut, and on which part trains the model.

Each flight is cut at nine places, and either part trains the model that the other one judges. The two answers of a cut
agree if their verdicts are equal and one set of effects is admitted by both: the named effects, or some of them with
what the answer itself calls not separable from them in their place."""
import collections
import itertools
import statistics

from measure.lab_figures import asked, compact_table
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


def spread(values, digits=4):
    return f"{statistics.median(values):.{digits}f}({min(values):.{digits}f}-{max(values):.{digits}f})"


def errors(both):
    """-> spreads over the answers: error on unseen data as declared and with the effects, share [%] that they explain"""
    declared, final = ([one[model]["validation_rmse"] for one in both] for model in ("declared", "final"))
    return [spread(declared), spread(final), spread([100 * (1 - (after / before) ** 2) for before, after in zip(declared, final)], 0)]


def row(name, cuts):
    """-> the counts and the row of one flight"""
    both = [answer for pair in cuts for answer in pair]
    verdicts = [first["verdict"] == second["verdict"] for first, second in cuts]
    literal = [same and named(first) == named(second) for same, (first, second) in zip(verdicts, cuts)]
    agree = [same and bool(admitted(first) & admitted(second)) for same, (first, second) in zip(verdicts, cuts)]
    counts = [sum(verdicts), sum(agree), sum(literal), len(cuts)]
    words = [f"{sum(one['verdict'] == verdict for one in both)}" for verdict in ("explained", "unexplained", "nothing_missing")]
    often = collections.Counter(effect for one in both for effect in named(one))
    return counts, [name, "/".join(words), "/".join(map(str, counts[:3])), *errors(both),
                    ", ".join(f"{effect.replace('_', ' ')} {count}" for effect, count in sorted(often.items()))]


def cuts_table(all_answers):
    """@param all_answers  {name of the flight: answers()}"""
    rows = [["flight", "explained/unexplained/nothing missing", "cuts that agree in verdict/effects/literally", "declared", "with the effects",
             "explained [%]", "named"]]
    total = [0, 0, 0, 0]
    for name, cuts in all_answers.items():
        counts, cells = row(name, cuts)
        total = [a + b for a, b in zip(total, counts)]
        rows.append(cells)
    return compact_table(*rows, ["together", "", "/".join(map(str, total[:3])) + f" of {total[3]}", "", "", "", ""])


def model_of(both):
    """-> the effects that more than half of the answers have in their model, beside the trim that every model has"""
    models = collections.Counter(frozenset(one["final"]["structure"][1:]) | {one["final"]["structure"][0]} for one in both)
    effects, count = models.most_common(1)[0]
    words = ", ".join(sorted(effect.replace("_", " ") for effect in effects - {"first_order", "trim_offset"}))
    return words if 2 * count > len(both) else "cannot tell"


def first_page(all_answers):
    """The first aircraft's axes: errors over all cuts, the model, and how often it is the whole explanation."""
    rows = [["axis", "declared first order", "with effects", "explained [%]", "effects", "verdict \"explained\"", "1 s ahead, declared", "with effects"]]
    for name, axis in (("roll [rad]", "roll"), ("pitch [rad]", "pitch"), ("climb [m/s]", "climb"), ("yaw rate [rad/s]", "yaw rate")):
        both = [answer for pair in all_answers[axis] for answer in pair]
        ahead = [f"{statistics.median(one[model]['horizon_rmse']['1.0'] for one in both):.4f}" for model in ("declared", "final")]
        rows.append([name, *errors(both), model_of(both), f"{sum(one['verdict'] == 'explained' for one in both)}/{len(both)}", *ahead])
    return compact_table(*rows)


def cuts(workspace):
    """Verdicts, effects and errors of every measured flight, cut at nine places, both ways."""
    found = {flight[0]: answers(workspace, flight) for flight in FLIGHTS}
    return {"identify.cuts": cuts_table(found), "identify.measured": first_page(found)}


SOURCES = [Source(("identify.cuts", "identify.measured"), cuts, quick=False)]
