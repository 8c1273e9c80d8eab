"""What a cheap camera does to a picture: light, white balance, blur, sharpening, noise, compression, a dirty lens."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

ImageBgr = NDArray[np.uint8]
Rng = np.random.Generator


def degrade(image_bgr: ImageBgr, rng: Rng) -> ImageBgr:
    """A new picture of the same size. Boxes stay where they are: nothing here moves an edge by half a pixel."""
    picture = image_bgr.astype(np.float32)
    if rng.random() < 0.9:
        balance = np.exp(rng.normal(0, 0.10, 3))
        gamma = math.exp(rng.normal(0, 0.22))
        gain = math.exp(rng.normal(0.0, 0.25))
        table = (255.0 * (np.arange(256) / 255.0) ** gamma)[:, None] * balance * gain
        table = np.clip(table + rng.normal(0, 8) * (rng.random() < 0.4), 0, 255).astype(np.float32)
        picture = np.dstack([table[image_bgr[:, :, c], c] for c in range(3)])
    if rng.random() < 0.35:
        grey = picture.mean(axis=2, keepdims=True)
        picture = grey + (picture - grey) * rng.uniform(0.2, 1.5)
    if rng.random() < 0.3:
        rows, columns = picture.shape[:2]
        y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j].astype(np.float32)
        cu, cv_ = rng.normal(0, 0.4, 2)
        off = np.clip((x - cu) ** 2 + (y - cv_) ** 2, 0, 1.5) / 1.5
        picture = picture * (1 - rng.uniform(0, 0.7) * off)[:, :, None]
    kind = rng.random()
    if kind < 0.35:
        picture = cv2.GaussianBlur(picture, (0, 0), float(rng.uniform(0.3, 1.3)))
    elif kind < 0.5:
        picture = _motion(picture, rng)
    elif kind < 0.65:
        soft = cv2.GaussianBlur(picture, (0, 0), float(rng.uniform(0.6, 1.5)))
        picture = picture + float(rng.uniform(0.3, 1.6)) * (picture - soft)
    if rng.random() < 0.75:
        sigma = float(rng.uniform(0.5, 9.0)) * float(rng.uniform(0.3, 1.0))
        noise = rng.standard_normal((picture.shape[0], picture.shape[1], 3), np.float32)
        if rng.random() < 0.3:
            noise = 1.7 * cv2.GaussianBlur(noise, (3, 3), 0.7)
        picture = picture + sigma * noise
    out = np.clip(picture, 0, 255).astype(np.uint8)
    if rng.random() < 0.4:
        quality = int(rng.integers(30, 95))
        _, coded = cv2.imencode(".jpg", out, [cv2.IMWRITE_JPEG_QUALITY, quality])
        out = np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR), np.uint8)
    return out


def _motion(picture: NDArray[np.float32], rng: Rng) -> NDArray[np.float32]:
    """A turning robot smears sideways."""
    length = int(rng.integers(2, 7))
    kernel = np.zeros((7, 7), np.float32)
    angle = rng.normal(0, 0.25)
    reach = 0.5 * length * np.array([math.cos(angle), math.sin(angle)])
    cv2.line(kernel, np.int32(np.round(3 - reach)).tolist(), np.int32(np.round(3 + reach)).tolist(), 1.0)
    return np.asarray(cv2.filter2D(picture, -1, kernel / kernel.sum()), np.float32)
