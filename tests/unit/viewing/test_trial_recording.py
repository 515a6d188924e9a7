"""States of a simulated trial, and the row that it is to repeat."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pybullet
import pytest

from pipeline.commands.watch import _own_row
from pipeline.config import compose
from pipeline.data.tables import write_table
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import required_scene
from pipeline.stages.inputs import artifacts
from pipeline.viewing.errors import ViewError
from pipeline.viewing.recording import Recording, StateRecorder
from pipeline.viewing.trial_rows import conditions_of, trial_row
from robots import load_robot
from robots.bodies import link_poses
from robots.locations import FOLDER

CONFIG = compose(["profile=smoke"]).grasp
ROWS = FOLDER / "results" / "studies" / "human_in_the_loop_trials.csv"
RATE = 20.0


@pytest.fixture(scope="module")
def recorded() -> tuple[Recording, list[float], dict[str, Any]]:
    """A trial's begin: an object that falls from the air, the arm that goes elsewhere."""
    robot = load_robot("panda")
    recorder = StateRecorder(CONFIG.recording, RATE, film=False)
    seen: list[float] = []
    with Scene(robot, required_scene(CONFIG, "panda"), CONFIG.physics) as scene:
        body = scene.lay(CONFIG.objects["banana"], (0.5, 0.1), 0.3)
        scene.wait(0.1)
        scene.on_step = lambda: seen.append(scene.time_s)
        recorder.attach(scene, end_s=0.6)
        goal = robot.home + 0.2
        scene.command(goal)
        scene.mark("there")
        scene.wait(0.9)
        tip = scene.tip_position()
        place, turn = scene.client.getBasePositionAndOrientation(body)
    return recorder.recording, seen, {"tip": tip, "place": place, "turn": turn}


def test_frames_come_at_the_rate_until_the_end_and_others_still_hear(recorded: Any) -> None:
    recording, seen, _ = recorded
    times = [frame.time for frame in recording.frames]
    assert len(seen) == round(0.9 * CONFIG.physics.rate)
    assert times[0] == pytest.approx(1 / CONFIG.physics.rate)
    assert np.diff(times) == pytest.approx(1 / RATE, abs=1.1 / CONFIG.physics.rate)
    assert recording.duration == pytest.approx(0.5, abs=1 / RATE)
    assert recording.at(-1.0) is recording.frames[0]
    assert recording.at(9.0) is recording.frames[-1]
    assert recording.at(times[3] + 0.001) is recording.frames[3]
    assert recording.phase(-0.1) == "there"
    assert recording.phase(0.1) == ""


def test_joints_give_the_simulators_own_tip_and_shapes_its_bodies(recorded: Any) -> None:
    recording, _, end = recorded
    robot = load_robot("panda")
    rest = robot.positions(robot.home)
    first, last = recording.frames[0], recording.frames[-1]
    assert {*robot.joint_names} <= set(last.joints)
    poses = [link_poses(robot.urdf, {**rest, **each.joints}) for each in (first, last)]
    tips = [pose[robot.tip][:3, 3] for pose in poses]
    assert np.linalg.norm(tips[1] - tips[0]) > 0.02
    assert np.linalg.norm(tips[1] - end["tip"]) < np.linalg.norm(tips[0] - end["tip"])
    assert last.bodies.shape == (len(recording.shapes), 7)
    assert last.bodies[-1, :3] == pytest.approx(end["place"], abs=2e-3)
    assert np.linalg.norm(last.bodies[:, 3:], axis=1) == pytest.approx(1.0)
    assert all(shapes for shapes in recording.shapes)


def test_a_capsule_is_a_cylinder_with_two_round_ends() -> None:
    from pipeline.viewing.recording import body_shapes

    class Client:
        def getVisualShapeData(self, body: int) -> list[Any]:  # noqa: N802 - PyBullet's name
            turn = pybullet.getQuaternionFromEuler([0.0, np.pi / 2, 0.0])  # z becomes x
            size = (0.4, 0.1, 0.0)
            return [(0, -1, pybullet.GEOM_CAPSULE, size, b"", (0.0, 0.0, 1.0), turn, (1, 0, 0, 1))]

    cylinder, *ends = body_shapes(Client(), 0)
    assert (cylinder.kind, cylinder.size) == ("cylinder", (0.1, 0.4))
    assert [end.kind for end in ends] == ["sphere", "sphere"]
    assert ends[0].origin[:3, 3] == pytest.approx([-0.2, 0.0, 1.0])
    assert ends[1].origin[:3, 3] == pytest.approx([0.2, 0.0, 1.0])


def test_a_row_says_the_keys_that_it_was_made_with() -> None:
    keys = conditions_of(trial_row(ROWS, "nicol", 17))
    expected = {"grasp.solver": "cycleik", "seed": 0, "perception": "camera", "agent": "policy"}
    assert keys.items() >= expected.items()
    config = compose(["robot=nicol", *(f"{key}={value}" for key, value in keys.items())])
    assert (config.grasp.physics.rate, config.grasp.physics.iterations) == (240, 100)
    assert config.agent.kind == "policy"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("trial,robot,class,reason\n3,panda,Success,x\n", "no trial 17 of nicol.*there: none"),
        ("trial,robot,class,reason\n3,nicol,Success,x\n", "no trial 17 of nicol.*there: 3 to 3"),
        ("trial,robot\n17,nicol\n", r"lacks the column\(s\) class, reason"),
        ("", "cannot be read as rows of trials"),
    ],
)
def test_rows_that_do_not_serve_are_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "rows.csv"
    path.write_text(text)
    with pytest.raises(ViewError, match=words):
        trial_row(path, "nicol", 17)


def test_rows_that_are_not_there_are_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ViewError, match="cannot be read as rows of trials"):
        trial_row(tmp_path / "no.csv", "nicol", 17)


def test_a_trial_that_the_run_has_not_made_yet_is_watched_without_a_row(tmp_path: Path) -> None:
    run = [f"results_dir={tmp_path}", "robot=nicol"]
    folder = artifacts(compose(run)).grasp("nicol")
    assert _own_row(compose([*run, "view.trial=17"])) is None
    write_table(folder / "trials.parquet", pd.read_csv(ROWS), {})
    row = _own_row(compose([*run, "view.trial=17"]))
    assert row is not None
    assert row["trial"] == 17
    assert _own_row(compose([*run, "view.trial=9999"])) is None
