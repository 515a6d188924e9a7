"""Poses solved side by side: as one by one, and each as if it were alone."""

import pickle
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import baselines
import baselines.refine
from baselines.lanes import LANES
from baselines.lanes_kernel import refine_lanes
from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, LmOptions, refine_rows
from baselines.refine import Refined, refine
from baselines.seed_library import SeedLibrary, build_seed_library
from robots import Robot, available_robots, load_robot
from tests.small_arms import arm, save
from tests.unit.baselines.test_lm import MIXED

Array = np.ndarray
WIDE = '<limit lower="-2.5" upper="2.5" velocity="1" effort="1"/>'


def robot_of(kind: str | int, folder: Path) -> Robot:
    if kind == "mixed":
        return load_robot(urdf=MIXED, base="bench", tip="tool")
    if kind == "sliding":
        text = arm(3, kind="prismatic")
        return load_robot(urdf=save(folder, text))
    if kind == "turning for ever":
        return load_robot(urdf=save(folder, arm(6, kind="continuous")))
    if isinstance(kind, int):
        return load_robot(urdf=save(folder, arm(kind, limit=WIDE)))
    return load_robot(kind)


@pytest.fixture(
    scope="module",
    params=[*available_robots(), "mixed", "sliding", "turning for ever", 1, 4, 5, 10, 20],
    ids=str,
)
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    return robot_of(request.param, tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def options_for(robot: Robot, **changes: int) -> LmOptions:
    solver = baselines.load("lm", robot)
    assert isinstance(solver, LevenbergMarquardt)
    # Poses out of reach serve as hard ones here: a proof would end them early.
    return solver.options(None)._replace(iterations=5000, nearest_starts=0, **changes)


def reachable(robot: Robot, count: int, seed: int = 5) -> Array:
    return robot.forward_kinematics(robot.sample(count, seed=seed, collision_free=False))


def homes(robot: Robot, count: int) -> Array:
    return np.tile(robot.home, (count, 1, 1))


def one_by_one(
    robot: Robot, poses: Array, seeds: Array, options: LmOptions, library: SeedLibrary | None = None
) -> Refined:
    """The reference: the scalar kernel."""
    return refine(robot, poses, seeds, options, library=library, side_by_side=False)


def assert_same(one: Refined, other: Refined) -> None:
    assert np.array_equal(one.joints, other.joints)
    assert np.array_equal(one.status, other.status)
    assert np.array_equal(one.iterations, other.iterations)
    assert np.array_equal(one.starts, other.starts)


def assert_equal_to_one_by_one(
    robot: Robot,
    poses: Array,
    seeds: Array,
    options: LmOptions,
    library: SeedLibrary | None,
    lanes: Refined,
) -> None:
    """As the scalar kernel, step by step, up to rounding."""
    scalar = one_by_one(robot, poses, seeds, options, library)
    assert np.array_equal(lanes.status, scalar.status)
    assert np.array_equal(lanes.starts, scalar.starts)
    assert np.array_equal(lanes.iterations, scalar.iterations)
    assert np.abs(lanes.joints - scalar.joints).max() < 1e-6  # also the best of what failed


def largest_errors(robot: Robot, joints: Array, poses: Array) -> tuple[float, float]:
    """Largest distance [m] and angle [rad], by Pinocchio."""
    model, frame = robot.pinocchio()
    data = model.createData()
    errors = np.zeros((len(poses), 2))
    for row, pose in enumerate(poses):
        pinocchio.framesForwardKinematics(model, data, joints[row])
        reached = data.oMf[frame]
        goal = pinocchio.XYZQUATToSE3(pose[[0, 1, 2, 4, 5, 6, 3]])
        errors[row, 0] = np.linalg.norm(reached.translation - goal.translation)
        errors[row, 1] = np.linalg.norm(pinocchio.log3(reached.rotation.T @ goal.rotation))
    return tuple(errors.max(axis=0).tolist())


def test_lanes_do_what_the_scalar_kernel_does(robot: Robot) -> None:
    """The same descents, step by step: rounding turns no decision of these."""
    poses = reachable(robot, 301)
    options = options_for(robot)
    lanes = refine(robot, poses, homes(robot, 301), options)
    scalar = one_by_one(robot, poses, homes(robot, 301), options)
    same = (lanes.iterations == scalar.iterations) & (lanes.starts == scalar.starts)
    assert same.mean() > 0.99
    assert np.abs(lanes.joints - scalar.joints)[same].max() < 1e-6
    assert np.array_equal(lanes.status, scalar.status)


def test_what_is_found_holds_by_pinocchio_and_inside_the_limits(robot: Robot) -> None:
    poses = reachable(robot, 203, seed=6)
    options = options_for(robot)
    lanes = refine(robot, poses, homes(robot, 203), options)
    assert lanes.found.mean() >= one_by_one(robot, poses, homes(robot, 203), options).found.mean()
    assert (lanes.joints >= robot.lower).all() and (lanes.joints <= robot.upper).all()
    if len(robot.chain.variable) == robot.dof:  # Pinocchio's model has no followers
        found = lanes.found
        errors = largest_errors(robot, lanes.joints[found], poses[found])
        assert max(errors) < 1.0001e-4


def test_an_answer_is_that_of_the_pose_alone(robot: Robot) -> None:
    count = 3 * LANES + 5
    poses = reachable(robot, count, seed=7)
    poses[5] += [9, 0, 0, 0, 0, 0, 0]  # out of reach: it outlasts the others
    options = options_for(robot)._replace(iterations=300)
    together = refine(robot, poses, homes(robot, count), options)
    assert together.status[5] == OUT_OF_ITERATIONS
    order = np.random.default_rng(1).permutation(count)
    shuffled = refine(robot, poses[order], homes(robot, count), options)
    assert np.array_equal(shuffled.joints, together.joints[order])
    assert np.array_equal(shuffled.iterations, together.iterations[order])
    for row in (0, 5, count - 1):
        alone = refine(robot, poses[row : row + 1], homes(robot, 1), options)
        assert np.array_equal(alone.joints[0], together.joints[row])
        assert alone.iterations[0] == together.iterations[row]


@pytest.mark.parametrize("limit", [1, 5, 17, 40, 41, 100, 1000])
@pytest.mark.parametrize("seeded", [0, 1, 2])
def test_lanes_that_help_change_nothing(panda: Robot, limit: int, seeded: int) -> None:
    """A pose alone has eight lanes for its starts, one in the midst of a batch has one."""
    poses = reachable(panda, 240, seed=8)
    poses[::40] += [9, 0, 0, 0, 0, 0, 0]
    seeds = panda.sample(480, seed=3, collision_free=False).reshape(240, 2, 7)[:, :seeded].copy()
    library = build_seed_library(panda, 100, 3, seed=1)
    options = options_for(panda)._replace(iterations=limit)
    together = refine(panda, poses, seeds, options, library=library)
    assert_equal_to_one_by_one(panda, poses, seeds, options, library, together)
    hard = np.argsort(together.iterations)[-25:]
    for row in [*hard, *range(0, 240, 40)]:
        alone = refine(panda, poses[row : row + 1], seeds[row : row + 1], options, 1, library)
        assert np.array_equal(alone.joints[0], together.joints[row])
        assert alone.status[0] == together.status[row]
        assert alone.iterations[0] == together.iterations[row]
        assert alone.starts[0] == together.starts[row]


@pytest.mark.parametrize("starts", [1, 2, 7, 8, 9, 20])
def test_lanes_that_help_heed_the_number_of_starts(panda: Robot, starts: int) -> None:
    poses = reachable(panda, 3)
    poses[::2] += [9, 0, 0, 0, 0, 0, 0]
    options = options_for(panda)._replace(starts=starts)
    few = refine(panda, poses, homes(panda, 3), options)
    assert few.status[[0, 2]].tolist() == [OUT_OF_STARTS] * 2
    assert few.starts[[0, 2]].tolist() == [starts] * 2
    assert_equal_to_one_by_one(panda, poses, homes(panda, 3), options, None, few)


@pytest.mark.parametrize("count", [0, 1, 2, LANES - 1, LANES, LANES + 1, 2 * LANES + 3])
def test_any_number_of_poses(panda: Robot, count: int) -> None:
    poses = reachable(panda, 40)
    options = options_for(panda)
    many = refine(panda, poses, homes(panda, 40), options)
    few = refine(panda, poses[:count], homes(panda, count), options)
    assert few.joints.shape == (count, panda.dof) and few.found.all()
    assert np.array_equal(few.joints, many.joints[:count])


def test_threads_share_the_queue(panda: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(baselines.refine, "POSES_PER_THREAD", 1)
    monkeypatch.setattr("numba.config.NUMBA_NUM_THREADS", 5)
    poses = reachable(panda, 200)
    library = build_seed_library(panda, 200, 3, seed=1)
    options = options_for(panda)
    one = refine(panda, poses, homes(panda, 200), options, 1, library)
    for threads in (2, 5, 0):
        for _ in range(5):
            assert_same(one, refine(panda, poses, homes(panda, 200), options, threads, library))
    assert one.found.all() and (one.time_s > 0).all()


def test_more_threads_than_poses(panda: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(baselines.refine, "POSES_PER_THREAD", 1)
    monkeypatch.setattr("numba.config.NUMBA_NUM_THREADS", 5)
    assert refine(panda, reachable(panda, 2), homes(panda, 2), options_for(panda), 5).found.all()


@pytest.mark.parametrize("seeded", [0, 1, 3])
def test_seeds_then_the_library_then_random_starts(panda: Robot, seeded: int) -> None:
    poses = reachable(panda, 150)
    seeds = panda.sample(150 * max(seeded, 1), seed=2, collision_free=False)
    seeds = seeds.reshape(150, max(seeded, 1), 7)[:, :seeded].copy()
    library = build_seed_library(panda, 300, 4, seed=1)
    options = options_for(panda)
    lanes = refine(panda, poses, seeds, options, library=library)
    assert lanes.starts.max() > seeded + 4
    assert_equal_to_one_by_one(panda, poses, seeds, options, library, lanes)
    alone = refine(panda, poses[9:10], seeds[9:10], options, library=library)
    assert np.array_equal(alone.joints[0], lanes.joints[9])


@pytest.mark.parametrize("limit", [1, 2, 7, 40])
def test_iterations_are_limited(panda: Robot, limit: int) -> None:
    poses = reachable(panda, 100)
    options = options_for(panda)._replace(iterations=limit)
    lanes = refine(panda, poses, homes(panda, 100), options)
    assert_equal_to_one_by_one(panda, poses, homes(panda, 100), options, None, lanes)
    assert lanes.iterations.max() == limit
    assert OUT_OF_ITERATIONS in lanes.status and set(lanes.status) <= {FOUND, OUT_OF_ITERATIONS}
    assert (lanes.iterations[~lanes.found] == limit).all()


@pytest.mark.parametrize("starts", [0, 1, 3])
def test_starts_are_limited(panda: Robot, starts: int) -> None:
    poses = reachable(panda, 100)
    options = options_for(panda, starts=starts)
    lanes = refine(panda, poses, homes(panda, 100), options)
    assert_equal_to_one_by_one(panda, poses, homes(panda, 100), options, None, lanes)
    assert (lanes.status == OUT_OF_STARTS).any()


def test_a_seed_at_the_solution_is_returned_untouched(robot: Robot) -> None:
    joints = robot.sample(20, seed=9, collision_free=False)
    poses = robot.forward_kinematics(joints)
    lanes = refine(robot, poses, joints[:, None], options_for(robot))
    assert (lanes.iterations == 0).all() and (lanes.starts == 1).all()
    assert np.array_equal(lanes.joints, robot.nearest_turns(joints))


def test_no_types_or_layouts_compile_it_again(panda: Robot) -> None:
    poses = reachable(panda, 12)
    options = options_for(panda)
    refine(panda, poses, homes(panda, 12), options)
    before = len(refine_lanes.signatures)
    library = build_seed_library(panda, 50, 2, seed=1)
    again = pickle.loads(pickle.dumps(panda))
    refine(again, poses.astype(np.float32).astype(np.float64), homes(panda, 12), options)
    refine(panda, np.asfortranarray(poses), homes(panda, 12), options, library=library)
    refine(panda, poses[::2], np.asfortranarray(homes(panda, 6)), options)
    refine(panda, poses, np.empty((12, 0, 7)), options, library=pickle.loads(pickle.dumps(library)))
    refine(panda, poses, np.broadcast_to(panda.home, (12, 1, 7)), options._replace(starts=2))
    one, home = np.broadcast_to(poses[0], (1, 7)), np.broadcast_to(panda.home, (1, 1, 7))
    refine(panda, one, home, options)  # read-only, and in order as it stands
    assert len(refine_lanes.signatures) == before == 1
    for timed in (options._replace(time_ns=10**9), options._replace(time_ns=10**9, starts=2)):
        refine(panda, poses, homes(panda, 12), timed)
        refine(panda, one, home, timed)
    assert len(refine_rows.signatures) == 1


def test_a_time_limit_is_kept_pose_by_pose(panda: Robot) -> None:
    far = np.tile([9.0, 0, 0, 1, 0, 0, 0], (2 * LANES, 1))
    options = options_for(panda)._replace(iterations=2**62, time_ns=1_000_000)
    refined = refine(panda, far, homes(panda, 2 * LANES), options)
    assert set(refined.solution().reason) == {"out of time"}
    assert (refined.time_s >= 1e-3).all()


def test_the_time_of_a_batch_is_shared_out_by_work(panda: Robot) -> None:
    poses = reachable(panda, 300)
    poses[7] = [9.0, 0, 0, 1, 0, 0, 0]
    refined = refine(panda, poses, homes(panda, 300), options_for(panda))
    share = refined.time_s / (refined.iterations + refined.starts)
    assert np.allclose(share, share[0])
    assert refined.time_s.argmax() == 7
