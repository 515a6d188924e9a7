"""An open-vocabulary detector of the user's: OWL-ViT or its like through `transformers`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from pipeline.errors import PerceptionError
from pipeline.packages import optional_package
from pipeline.perception.config import PerceptionConfig
from pipeline.perception.detection import Detection, check_image, distinct


class OpenVocabularyDetector:
    """Finds what a text describes.

    The model says boxes alone, so the centroid pixel is the middle of the box; for a bent object
    that is centimetres off.

    Attributes:
        names: The classes; each is turned into a text by the prompt.
    """

    def __init__(self, config: PerceptionConfig, names: Sequence[str]) -> None:
        """Load a model from a local folder; nothing is downloaded, and no code of it is run.

        Args:
            config: Folder of the model, the prompt, and which detections are reported.
            names: Classes to look for.

        Raises:
            PerceptionError: transformers is not installed, there is no such folder or no model in
                it, or no classes are named.
        """
        if not names:
            raise PerceptionError("an open-vocabulary detector needs the names to look for")
        self.names, self._config = tuple(names), config
        self._texts = [
            config.vocabulary.prompt.format(name=name.replace("_", " ")) for name in names
        ]
        self._processor, self._model = _load(config.vocabulary.model)

    def detect(self, image: NDArray[np.uint8]) -> list[Detection]:
        """Find objects in a picture (height, width, 3), highest score first.

        Raises:
            PerceptionError: The picture has another shape or type.
        """
        check_image(image)
        inputs = self._processor(
            text=[self._texts], images=image, return_tensors="pt", truncation=True
        )
        with torch.inference_mode():
            outputs = self._model(**inputs)
        (answer,) = self._processor.post_process_grounded_object_detection(
            outputs, threshold=self._config.threshold, target_sizes=[image.shape[:2]]
        )
        boxes = zip(
            answer["scores"].tolist(),
            answer["labels"].tolist(),
            answer["boxes"].tolist(),
            strict=True,
        )
        found = []
        for score, kind, (x0, y0, x1, y1) in sorted(boxes, reverse=True):
            centroid = (0.5 * (x0 + x1), 0.5 * (y0 + y1))
            found.append(Detection(self.names[int(kind)], score, (x0, y0, x1, y1), centroid))
        return distinct(found[: self._config.max_detections], self._config.merge_overlap)


def _load(folder: str | None) -> tuple[Any, Any]:
    """Processor and model of a folder."""
    if folder is None:
        raise PerceptionError(
            "perception.detector=open_vocabulary needs perception.vocabulary.model: the local "
            "folder of an OWL-ViT-class model, as transformers' save_pretrained leaves it"
        )
    if not (Path(folder) / "config.json").is_file():
        raise PerceptionError(
            f"there is no model in {folder}: expected a folder with config.json, "
            "preprocessor_config.json, a tokenizer and model.safetensors"
        )
    transformers = optional_package("perception.detector=open_vocabulary", PerceptionError)
    try:
        processor = transformers.AutoProcessor.from_pretrained(folder, local_files_only=True)
        model = transformers.AutoModelForZeroShotObjectDetection.from_pretrained(
            folder, local_files_only=True, use_safetensors=True
        )
    except (OSError, ValueError, KeyError, ImportError) as error:
        sentence = " ".join(str(error).split())
        raise PerceptionError(f"the model in {folder} cannot be loaded: {sentence}") from error
    return processor, model.eval()
