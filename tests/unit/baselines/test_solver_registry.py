import pytest

import baselines
from baselines import SettingError, SkippedSolver, SolverError, UnknownSolverError, registry
from robots import load_robot

CORE = {"lm", "pinocchio", "placo", "pytorch_kinematics", "trac_ik", "bio_ik"}


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "FOLDER", tmp_path)
    return tmp_path


def test_the_core_solvers_are_registered():
    assert set(baselines.names()) >= CORE


def test_an_unknown_name_gets_the_nearest_and_all():
    with pytest.raises(UnknownSolverError, match=r"did you mean 'placo'.*trac_ik"):
        registry.settings("plako")


def test_an_unknown_setting_gets_the_nearest(panda):
    with pytest.raises(SettingError, match="no setting 'dampin'; did you mean 'damping"):
        baselines.load("lm", panda, dampin=1.0)


@pytest.mark.parametrize("value", ["much", True, None.__class__])
def test_a_setting_of_another_type_is_refused(panda, value):
    with pytest.raises(SettingError, match="damping"):
        baselines.load("lm", panda, damping=value)


def test_a_whole_number_serves_as_a_float(panda):
    assert baselines.load("lm", panda, damping=1)._options.damping == 1


def test_a_loaded_solver_knows_its_name_and_budget(panda):
    solver = baselines.load("lm", panda, iterations=9)
    assert solver.name == "lm"
    assert solver.budget == baselines.Budget(iterations=9)
    assert solver.settings["iterations"] == 9
    assert solver.settings["damping"] == registry.settings("lm")["damping"]


def test_a_missing_package_is_a_reason_to_skip(folder, panda):
    (folder / "gone.yaml").write_text("_target_: no_such_package.Thing\n")
    # The target's own package is missing, which is a mistake in the YAML ...
    with pytest.raises(SolverError, match="cannot import"):
        baselines.skip("gone")
    # ... unlike a package that its module imports.
    (folder / "needs.py").write_text("import no_such_package\n")
    (folder / "needs.yaml").write_text("_target_: needs.Thing\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        assert "no_such_package" in baselines.skip("needs")
        with pytest.raises(SkippedSolver, match="no_such_package"):
            baselines.load("needs", panda)


@pytest.mark.parametrize("text", ["", "- 1", "tolerance: 1", "_target_: 3"])
def test_a_yaml_without_a_target_is_refused(folder, text):
    (folder / "bad.yaml").write_text(text)
    with pytest.raises(SolverError, match="_target_"):
        registry.settings("bad")


@pytest.mark.parametrize("target", ["baselines.lm.NoSuchClass", "baselines.Budget"])
def test_a_target_that_is_no_solver_is_refused(folder, target):
    (folder / "bad.yaml").write_text(f"_target_: {target}\n")
    with pytest.raises(SolverError, match=target):
        baselines.skip("bad")
