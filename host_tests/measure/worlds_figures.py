# SPDX-License-Identifier: BSD-3-Clause
"""What holds in the guide's example world, whose physics another program computes (firmware/companion/guide/worlds)."""
import json
import pathlib
import re
import tempfile

from measure.evening_figures import M100
from measure.lab_figures import LAB, table
from measure.marked import Figure
from measure.workspace import Source

WORLDS = {"calm": [0, 0, 0], "wind": [3, 2, 0], "wind8": [6.6, 4.5, 0]}
ROTOR_LAGS_S = (0.025, 0.05, 0.065)


def plants(folder):
    """Writes a plant file for each wind. -> {name: file}"""
    files = {name: pathlib.Path(folder) / f"{name}.toml" for name in WORLDS}
    for name, file in files.items():
        file.write_text(f"[air]\nwind_m_s = {WORLDS[name]}\n")
    return files


def body(workspace, *options):
    return " ".join([f"exec /usr/bin/python3 '{workspace.root}/firmware/companion/guide/worlds/quadrotor.py' {{port}}",
                     "--wind={wind} --seed {seed}", *options])


def tasks(workspace):
    """Pose error of the paper's tasks, ours and --law paper, and how fast both programs are."""
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        printed = workspace.run(workspace.program(LAB), "experiments", "--plant", plants(folder)["wind"], "--baseline",
                                "--body-command", body(workspace), "--json", answer)
        scores = json.loads(answer.read_text())
    rows = [["task", "ours, pose [m]", "`--law paper`, pose [m]"]]
    rows += [[f"{task}, {air}", f"{cell['pose_m']:.4f}", f"{cell['paper_law']['pose_m']:.4f}"]
             for task, airs in scores.items() if isinstance(airs, dict) for air, cell in airs.items()]
    return {"worlds.tasks": table(*rows), "worlds.speed": Figure(re.search(r"(\d+) times real time", printed)[1])}


def campaigns(workspace):
    """How many of the campaign's flights stay, with rotors of several time constants."""
    said = []
    with tempfile.TemporaryDirectory() as folder:
        for lag_s in ROTOR_LAGS_S:
            printed = workspace.run(workspace.program(LAB), "campaign", *plants(folder).values(), "--flights", "2",
                                    "--body-command", body(workspace, f"--rotor-lag {lag_s}"), may_fail=True)
            said.append(f"{1000 * lag_s:.0f} ms: " + printed.strip().splitlines()[-1].rstrip("."))
    return {"worlds.campaign": Figure("; ".join(said))}


def pilot_logs(workspace):
    """Verdicts of identify on the pilot's logs of 40 drawn aircraft."""
    printed = workspace.run("python3", "host_tests/scenario/body/pilot_logs.py", workspace.program(M100),
                            workspace.program(LAB), workspace.root, may_fail=True)
    return {"worlds.pilot_logs": Figure(printed.strip().splitlines()[-1])}


SOURCES = [Source(("worlds.tasks", "worlds.speed"), tasks, quick=False),
           Source(("worlds.campaign",), campaigns, quick=False),
           Source(("worlds.pilot_logs",), pilot_logs, quick=False)]
