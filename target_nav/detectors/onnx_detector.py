"""A trained network as a `Detector`: the same model as the C++ process runs, by OpenCV's dnn in Python.

It stands in where the C++ detector is not built, and it is what campaigns with rendered pictures look through.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import cv2
import numpy as np

from target_nav.detectors.detector import ImageBgr, check_picture
from target_nav.detectors.onnx_heads import (
    INPUT_HEIGHT,
    INPUT_WIDTH,
    Letterbox,
    ScoredBox,
    decode_heads,
    planes_of,
    stride_of,
)
from target_nav.detectors.second_look import GLANCE_SCORE_MIN, LOOK_HEIGHT, LOOK_WIDTH, Part, look_again
from target_nav.errors import DeviceError
from target_nav.state.types import RawDetection
from target_nav.utils import bowling_pin
from target_nav.utils.distance import Box

SCORE_MIN = 0.3
"""What is worth handing on: the camera process has a threshold of its own, `detector.score_min`."""


class OnnxDetector:
    """One class; the network's file does not say which."""

    def __init__(
        self, model: Path, class_name: str = bowling_pin.CLASS_NAME, score_min: float = SCORE_MIN
    ) -> None:
        """Raises:
        DeviceError: there is no such file, or it is not a network with heads as `docs/model.md` describes them.
        """
        cv2.setNumThreads(1)
        if not model.is_file():
            raise DeviceError(
                f"model {model} is not there; name an ONNX file, or leave it to the one in deploy/model"
            )
        self._class_name = class_name
        self._score_min = score_min
        try:
            self._net = cv2.dnn.readNetFromONNX(str(model))
            # A network of its own: a change of the input's size would plan the whole network anew each time.
            self._look_net = cv2.dnn.readNetFromONNX(str(model))
            self._names = self._net.getUnconnectedOutLayersNames()
            self._forward(self._look_net, np.full((1, 3, LOOK_HEIGHT, LOOK_WIDTH), 0.5, np.float32))
            heads = self._forward(self._net, np.full((1, 3, INPUT_HEIGHT, INPUT_WIDTH), 0.5, np.float32))
        except cv2.error as error:
            reason = str(error.err or error).splitlines()[0]
            raise DeviceError(
                f"model {model} cannot be run by OpenCV {cv2.__version__}: {reason}; is the file whole?"
            ) from error
        try:
            for head in heads:
                stride_of(head)
        except ValueError as error:
            raise DeviceError(f"model {model}: {error}; is it the network of deploy/model?") from error
        if not heads or not all(np.isfinite(head).all() for head in heads):
            raise DeviceError(
                f"model {model} answers nonsense to a grey picture; it may be corrupt, fetch it again"
            )

    @property
    def class_names(self) -> tuple[str, ...]:
        return (self._class_name,)

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        """Boxes in a picture of any size, best score first.

        Raises:
            ValueError: the picture is not uint8 of shape (height, width, 3).
        """
        check_picture(image_bgr)
        height, width = image_bgr.shape[:2]
        letterbox = Letterbox.of(width, height)
        heads = self._forward(self._net, letterbox.apply(image_bgr))
        glanced = decode_heads(heads, letterbox, width, height, min(self._score_min, GLANCE_SCORE_MIN))
        found = []
        for one in look_again(glanced, partial(self._look, image_bgr), width, height, self._score_min):
            box = Box.from_edges(one.left, one.top, one.right, one.bottom)
            found.append(
                RawDetection(self._class_name, one.score, box.u_px, box.v_px, box.width_px, box.height_px)
            )
        return tuple(found)

    def _look(self, image_bgr: ImageBgr, part: Part) -> list[ScoredBox]:
        height, width = image_bgr.shape[:2]
        pixels = image_bgr[part.top : part.top + part.height, part.left : part.left + part.width]
        # Linear, and nothing is done to a part of the look's own size.
        enlarged = np.asarray(cv2.resize(pixels, (LOOK_WIDTH, LOOK_HEIGHT)), np.uint8)
        heads = self._forward(self._look_net, planes_of(enlarged))
        scale = LOOK_WIDTH / part.width
        where = Letterbox(scale, -scale * part.left, -scale * part.top, LOOK_WIDTH, LOOK_HEIGHT)
        return decode_heads(heads, where, width, height, self._score_min, LOOK_HEIGHT, LOOK_WIDTH)

    def _forward(self, net: cv2.dnn.Net, blob: np.ndarray) -> list[np.ndarray]:
        net.setInput(blob)
        return [np.asarray(head, np.float32) for head in net.forward(self._names)]
