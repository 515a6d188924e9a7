import pickle
from collections.abc import Sequence

import numpy as np
import pytest

from robots import Robot, SamplingError, load_robot, sampling
from robots.description import Description
from robots.sampling import CHUNK, ChunkExecutor, Draw, Samples, sample_configurations


def test_samples_are_within_limits_and_free(two_link: Robot) -> None:
    joints = two_link.sample(3000, seed=1)
    assert joints.shape == (3000, 2) and joints.dtype == np.float64
    assert (joints >= two_link.lower).all() and (joints <= two_link.upper).all()
    assert not two_link.in_collision(joints).any()
    assert two_link.in_collision(two_link.sample(3000, collision_free=False)).any()


def test_seed_decides_and_count_does_not(two_link: Robot) -> None:
    many = two_link.sample(CHUNK + 100, seed=7)
    assert np.array_equal(two_link.sample(10, seed=7), many[:10])
    assert not np.array_equal(two_link.sample(10, seed=8), many[:10])


def test_who_draws_does_not_change_the_samples(two_link: Robot) -> None:
    count = (sampling.TRIAL + 3) * CHUNK
    alone = sample_configurations(two_link, count, seed=3)
    requested: list[int] = []

    def elsewhere(draw: Draw, numbers: Sequence[int]) -> list[Samples]:
        requested.extend(numbers)
        drawn = {number: pickle.loads(pickle.dumps(draw))(number) for number in numbers[::-1]}
        return [drawn[number] for number in numbers]

    shown: list[int] = []
    executor = ChunkExecutor(elsewhere, start_up_s=0.0)
    together = sample_configurations(
        two_link, count, seed=3, executor=executor, progress=shown.append
    )
    assert requested[0] == sampling.TRIAL
    assert np.array_equal(alone.joints, together.joints)
    assert (alone.drawn, alone.colliding) == (together.drawn, together.colliding)
    assert sum(shown) == count
    requested.clear()
    sample_configurations(
        two_link, count, seed=3, executor=ChunkExecutor(elsewhere, start_up_s=1e6)
    )
    assert requested == []


def test_workspace_filter_and_account() -> None:
    robot = load_robot("panda")
    object.__setattr__(
        robot.description, "workspace", np.array([[0.3, -0.4, 0.1], [0.6, 0.4, 0.6]])
    )
    found = sample_configurations(robot, 500, seed=2, workspace_filter=True)
    position = robot.forward_kinematics(found.joints)[:, :3]
    assert (position >= robot.workspace[0]).all() and (position <= robot.workspace[1]).all()
    assert found.outside > 0 and found.colliding > 0
    assert found.drawn * found.acceptance >= 500


def test_hopeless_filters_are_noticed(two_link: Robot, two_link_urdf) -> None:  # type: ignore[no-untyped-def]
    box = np.array([[5.0, 5.0, 5.0], [6.0, 6.0, 6.0]])
    robot = Robot(Description("far", "Far", two_link_urdf, "base", "tip", workspace=box))
    with pytest.raises(SamplingError, match="outside the workspace box"):
        robot.sample(1, workspace_filter=True)
    with pytest.raises(SamplingError, match="negative"):
        two_link.sample(-1)
    assert two_link.sample(0).shape == (0, 2)
