"""Targets, answers and losses of the centre-point network, against each other and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.errors import PerceptionError
from pipeline.perception.config import AugmentConfig, PerceptionConfig
from pipeline.perception.detection import Detection, overlap
from pipeline.perception.embedded import EmbeddedDetector, as_input, decode
from pipeline.perception.network import CentreNetwork
from pipeline.perception.studio import Label
from pipeline.perception.targets import loss, targets_of
from pipeline.perception.training import SWAPPED, augmented

NAMES, SIZE, SCALE = ("pear", "orange"), (320, 240), 0.5  # labels of pictures twice as large
CONFIG, PERCEPTION = compose().detector, compose().perception


def label(name: str, box: tuple[float, ...], centroid: tuple[float, float]) -> Label:
    return Label(name, box, centroid, (0.0, 0.0, 0.0))  # type: ignore[arg-type]


LABELS = [
    label("pear", (100.0, 100.0, 160.0, 140.0), (123.4, 117.0)),
    label("orange", (400.0, 300.0, 440.0, 340.0), (421.0, 319.0)),
    label("pear", (600.0, 440.0, 640.0, 480.0), (639.9, 479.9)),
]


def reporting(threshold: float, **limits: float) -> PerceptionConfig:
    """Which detections are reported."""
    return replace(PERCEPTION, threshold=threshold, **limits)


def answer(labels: list[Label]) -> tuple[torch.Tensor, torch.Tensor]:
    """What a perfect network would say."""
    targets = targets_of(labels, NAMES, SIZE, SCALE, CONFIG.heatmap_sigma)
    heat = torch.from_numpy(targets.heat).clamp(1e-4, 1 - 1e-4)
    return torch.logit(heat), torch.from_numpy(targets.offsets)


def test_a_perfect_answer_decodes_to_the_labels() -> None:
    found = decode(*answer(LABELS), NAMES, 1 / SCALE, reporting(0.5))
    assert len(found) == len(LABELS)
    for each in LABELS:
        near = [f for f in found if np.hypot(*np.subtract(f.centroid, each.centroid)) < 1e-3]
        assert [f.name for f in near] == [each.name]
        assert near[0].box == pytest.approx(each.box, abs=1e-3)


def test_two_objects_in_neighbouring_cells_are_reported_apart_by_class() -> None:
    near = label("orange", (150.0, 104.0, 190.0, 144.0), (170.0, 124.0))
    found = decode(*answer([LABELS[0], near]), NAMES, 1 / SCALE, reporting(0.5))
    assert {f.name for f in found} == {"pear", "orange"}


def test_only_the_highest_scores_are_reported_and_boxes_that_overlap_less_stay_apart() -> None:
    assert len(decode(*answer(LABELS), NAMES, 1 / SCALE, reporting(0.5, max_detections=1))) == 1
    logits, offsets = answer(LABELS[:1])
    logits[1] = logits[0] - 1.0
    both = decode(logits, offsets, NAMES, 1 / SCALE, reporting(0.3, merge_overlap=1.0))
    assert {each.name for each in both} == {"pear", NAMES[1]}


def test_of_two_classes_for_one_object_the_surer_stays() -> None:
    logits, offsets = answer(LABELS[:1])
    logits[1] = logits[0] - 1.0
    (found,) = decode(logits, offsets, NAMES, 1 / SCALE, reporting(0.3))
    assert found.name == "pear"


def test_a_mirrored_picture_has_mirrored_targets() -> None:
    """Training mirrors the targets of a picture in place of drawing those of the mirrored one."""
    mirrored = [
        label(
            each.name,
            (640 - each.box[2], each.box[1], 640 - each.box[0], each.box[3]),
            (640 - each.centroid[0], each.centroid[1]),
        )
        for each in LABELS
    ]
    plain = targets_of(LABELS, NAMES, SIZE, SCALE, CONFIG.heatmap_sigma)
    wanted = targets_of(mirrored, NAMES, SIZE, SCALE, CONFIG.heatmap_sigma)
    offsets = (
        plain.offsets[list(SWAPPED)][:, :, ::-1] * np.array([-1, 1, 1, 1, 1, 1])[:, None, None]
    )
    assert plain.known[:, ::-1] == pytest.approx(wanted.known)
    assert offsets == pytest.approx(wanted.offsets, abs=1e-5)
    assert plain.heat[:, :, ::-1] == pytest.approx(wanted.heat, abs=1e-5)


def test_the_loss_of_a_perfect_answer_is_nearly_nothing_and_of_a_wrong_one_is_not() -> None:
    targets = targets_of(LABELS, NAMES, SIZE, SCALE, CONFIG.heatmap_sigma)
    wanted = tuple(
        torch.from_numpy(part)[None] for part in (targets.heat, targets.offsets, targets.known)
    )
    logits = torch.where(wanted[0].eq(1.0), 20.0, -20.0)
    assert float(loss(logits, wanted[1], wanted, 1.0, 0.3)) < 1e-4  # type: ignore[arg-type]
    # Half a cell aside in u, everywhere it counts, is half a unit of the first weight.
    aside = wanted[1].clone()
    aside[:, 0] += 0.5
    assert float(loss(logits, aside, wanted, 1.0, 0.3)) == pytest.approx(0.5, abs=1e-3)  # type: ignore[arg-type]
    assert float(loss(-logits, wanted[1], wanted, 1.0, 0.3)) > 10.0  # type: ignore[arg-type]


def test_augmentation_is_drawn_from_its_seed_and_none_is_none() -> None:
    images = torch.randint(0, 255, (2, 24, 32, 3), dtype=torch.uint8)
    first, again, other = (augmented(images, CONFIG.augment, seed) for seed in (1, 1, 2))
    assert torch.equal(first, again) and not torch.equal(first, other)
    assert first.min() >= 0.0 and first.max() <= 1.0
    plain = augmented(images, AugmentConfig(0.0, 0.0, 0.0, 0.0), 1)
    assert torch.allclose(plain, images.permute(0, 3, 1, 2) / 255.0)


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((480, 640), np.uint8), r"got uint8 \(480, 640\)"),
        (np.zeros((480, 640, 3)), "8-bit"),
        (np.zeros((480, 480, 3), np.uint8), "320 x 240 pixels or a multiple, got 480 x 480"),
    ],
)
def test_other_pictures_are_refused(image: np.ndarray, words: str) -> None:
    detector = EmbeddedDetector(CentreNetwork(NAMES, CONFIG.network).eval(), reporting(0.3))
    with pytest.raises(PerceptionError, match=words):
        detector.detect(image)


def test_a_picture_is_reduced_by_the_mean_of_its_pixels() -> None:
    image = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    mean = image.reshape(240, 2, 320, 2, 3).mean(axis=(1, 3)).transpose(2, 0, 1)
    assert as_input(image, 320, 240).numpy() == pytest.approx(mean / 255, abs=1.5 / 255)


def test_an_untrained_network_sees_nothing() -> None:
    torch.manual_seed(0)
    detector = EmbeddedDetector(CentreNetwork(NAMES, CONFIG.network).eval(), reporting(0.3))
    found = detector.detect(np.full((480, 640, 3), 120, np.uint8))
    assert all(isinstance(each, Detection) for each in found)
    assert not found


def test_overlap_by_hand() -> None:
    assert overlap((0, 0, 2, 2), (1, 1, 3, 3)) == pytest.approx(1 / 7)
    assert overlap((0, 0, 1, 1), (2, 2, 3, 3)) == 0.0
    assert overlap((0, 0, 0, 0), (0, 0, 0, 0)) == 0.0
