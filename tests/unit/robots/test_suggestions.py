"""The sentence about a name that does not exist."""

from robots.suggestions import unknown_name


def test_it_names_the_nearest_and_all() -> None:
    assert unknown_name("robot", "pnada", ["panda", "nico"]) == (
        "there is no robot 'pnada'; did you mean 'panda'? Valid: nico, panda"
    )
    assert unknown_name("robot", "zzz", ["panda", "nico"]).endswith("'zzz'. Valid: nico, panda")
