"""`dvc`: dvc.yaml from the graph of stages; `code`: what code each of its steps depends on."""

from __future__ import annotations

import re

from pipeline.closure import source_tree
from pipeline.commands.arguments import command_parser
from pipeline.config import chosen, group_choices
from pipeline.data.files import write_text
from pipeline.errors import ConfigError, PipelineError
from pipeline.locations import CONF_DIR, need_checkout
from pipeline.stages.code_files import FOLDER, write_code_files
from pipeline.stages.dvc_file import dvc_yaml
from pipeline.stages.graph import NETWORKS
from robots.suggestions import unknown_name

ORIGINS = ("shipped", "default")  # of networks that the project has: see train.from
DVC = """\
dvc [profile=smoke] [networks=default]

Writes dvc.yaml from the graph of stages (pipeline/stages/graph.py). With profile=NAME it puts the
profile, its network and its search into conf/bench.yaml first, as `make reproduce PROFILE=NAME`
does, and with networks=default that networks of the project are trained again.
"""
CODE = f"""\
Writes {FOLDER}/<step>.json: the modules that each step of the graph runs, with a digest of each
that comments do not change. DVC runs it first and reruns the steps whose file has changed.
"""


def dvc(arguments: list[str]) -> int:
    """Write dvc.yaml, and the scale of the run where one is given."""
    overrides = command_parser("dvc", DVC).takes_overrides().parse(arguments).overrides
    path = need_checkout("dvc.yaml") / "dvc.yaml"
    for argument in overrides:
        key, _, value = argument.partition("=")
        if key == "profile":
            set_profile(value)
        elif key == NETWORKS and value in ORIGINS:
            _set({NETWORKS: value})
        else:
            valid = f"profile=NAME and {NETWORKS}={'|'.join(ORIGINS)}"
            raise PipelineError(f"dvc takes {valid}, got {argument}")
    write_text(path, dvc_yaml())
    print(path)
    return 0


def set_profile(profile: str) -> None:
    """Put a profile, its network and its search into conf/bench.yaml; comments and lists stay.

    Raises:
        ConfigError: There is no such profile.
    """
    if profile not in group_choices("profile"):
        raise ConfigError(unknown_name("profile", profile, group_choices("profile")))
    choices = chosen([f"profile={profile}"])
    _set({"profile": profile, "model": choices["model"], "tune": choices["tune"]})


def _set(values: dict[str, str]) -> None:
    """Replace values of conf/bench.yaml."""
    path = CONF_DIR / "bench.yaml"
    text = path.read_text(encoding="utf-8")
    for key, value in values.items():
        text = re.sub(rf"^({key}: *)\S+", rf"\g<1>{value}", text, flags=re.MULTILINE)
    if text != path.read_text(encoding="utf-8"):
        write_text(path, text)


def code(arguments: list[str]) -> int:
    """Write what code each step depends on."""
    command_parser("code", CODE).parse(arguments)
    write_code_files(source_tree(), need_checkout("code for DVC") / FOLDER)
    return 0
