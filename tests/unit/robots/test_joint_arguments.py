"""The gate for numbers: what is one, whatever its type and layout, and what is not."""

import time

import numpy as np
import pytest
import torch

from robots import Robot, RobotError, SamplingError, load_robot


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def layouts(q: np.ndarray) -> dict[str, object]:
    read_only = q.copy()
    read_only.setflags(write=False)
    odd = np.frombuffer(b"x" + q.tobytes(), dtype="u1")[1:].view("f8").reshape(q.shape)
    return {
        "read only": read_only,
        "unaligned": odd,
        "strided": np.repeat(q, 2, axis=1)[:, ::2],
        "fortran": np.asfortranarray(q),
        "big-endian": q.astype(">f8"),
        "long double": q.astype(np.longdouble),
        "objects": q.astype(object),
        "list": q.tolist(),
        "tensor": torch.tensor(q),
        "masked, nothing hidden": np.ma.masked_array(q),
        "reversed": q[::-1][::-1],
    }


@pytest.mark.parametrize("layout", layouts(np.zeros((1, 1))))
def test_types_and_layouts_give_the_same_without_compiling_anew(panda: Robot, layout: str) -> None:
    joints = panda.sample(20)
    given = layouts(joints)[layout]
    expected = panda.forward_kinematics(joints), panda.jacobian(joints), panda.in_collision(joints)
    before = time.perf_counter()
    found = panda.forward_kinematics(given), panda.jacobian(given), panda.in_collision(given)
    assert time.perf_counter() - before < 1.0
    for first, second in zip(expected, found, strict=True):
        assert np.array_equal(first, second)


BAD_JOINTS = {
    "nothing": [],
    "None": None,
    "a word": "a",
    "words": ["a"] * 7,
    "digits as text": np.zeros((1, 7)).astype(str),
    "six": np.zeros(6),
    "three axes": np.zeros((1, 1, 7)),
    "ragged": [[0.0] * 7, [0.0] * 6],
    "holes": [None] * 7,
    "complex": np.zeros(7, complex),
    "dates": np.zeros(7, "datetime64[s]"),
    "truth": np.zeros(7, bool),
    "NaN": np.full(7, np.nan),
    "infinite": np.full((2, 7), np.inf),
    "far": np.full(7, 1e300),
    "gradient": torch.zeros(7, requires_grad=True),
    "hidden": np.ma.masked_array(np.zeros(7), mask=[1, 0, 0, 0, 0, 0, 0]),
    "huge integers": [10**400] * 7,
    "a mapping": {"j": 1.0},
}


@pytest.mark.parametrize("case", BAD_JOINTS)
def test_what_is_no_joints_is_named(panda: Robot, case: str) -> None:
    for method in (panda.forward_kinematics, panda.jacobian, panda.in_collision):
        with pytest.raises(RobotError) as caught:
            method(BAD_JOINTS[case])  # type: ignore[operator]
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("count", "seed"), [(-1, 0), (1.5, 0), ("5", 0), (5, -1), (5, 1.5), (True, 0), (None, 0)]
)
def test_what_is_no_count_or_seed_is_named(panda: Robot, count: object, seed: object) -> None:
    with pytest.raises(SamplingError, match=r"number of samples|seed|negative"):
        panda.sample(count, seed)  # type: ignore[arg-type]


def test_counts_and_seeds_of_any_integer_type(panda: Robot) -> None:
    assert np.array_equal(panda.sample(np.int32(4), np.uint8(3)), panda.sample(4, 3))
    assert panda.sample(0).shape == (0, 7) and panda.sample(2, 2**70).shape == (2, 7)
