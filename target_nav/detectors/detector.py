"""What every detector is to the rest of the house: a picture in, boxes out.

The pixel detector implements it today; a trained network, or the reader of a C++ process, takes the same place.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from target_nav.state.types import RawDetection

ImageBgr = NDArray[np.uint8]


class Detector(Protocol):
    """Finds boxes in single pictures. It keeps no state between them: what lasts is the tracker's business."""

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes this detector can tell apart."""
        ...

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        """Boxes in `image_bgr`, uint8 of shape (height, width, 3), best score first, clipped at the borders.

        Raises:
            ValueError: the picture has another shape or type.
        """
        ...


def check_picture(image_bgr: ImageBgr) -> None:
    """Raises:
    ValueError: the picture is not uint8 of shape (height, width, 3).
    """
    if image_bgr.ndim != 3 or image_bgr.shape[2] != 3 or image_bgr.dtype != np.uint8:
        raise ValueError(
            f"picture is {image_bgr.dtype} of shape {image_bgr.shape}; a detector takes uint8 (height, width, 3)"
        )
