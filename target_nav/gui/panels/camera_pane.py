"""The picture with boxes: the target's is thick and bright, one that is not confirmed yet is dashed."""

from __future__ import annotations

from typing import Any

import numpy as np

from target_nav.gui.gtk import cairo
from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, text, veil
from target_nav.gui.panels.style import BACKGROUND, FONT, GREY, ORANGE, SKY, TEXT, YELLOW
from target_nav.gui.source import age_text
from target_nav.gui.view_camera import BoxView, CameraView

_HALF_FROM = 0.62
"""A picture shown smaller than this is halved first: a quarter of the bytes to copy and to scale."""


class CameraPane(Pane):
    def __init__(self, width: int = -1, height: int = -1) -> None:
        super().__init__(width, height)
        self._surface: Any = None
        self._pixels: Any = None
        self._shown: tuple[int, int] = (-1, 0)

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.camera
        scale = min(width / view.width_px, height / view.height_px)
        left, top = (width - scale * view.width_px) / 2.0, (height - scale * view.height_px) / 2.0
        cr.save()
        cr.translate(left, top)
        if view.image_bgr is not None:
            self._paint_picture(cr, view, scale)
        cr.scale(scale, scale)
        for box in view.boxes:
            _paint_box(cr, box, scale, view)
        cr.restore()
        if not view.fresh:
            veil(cr, width, height, view.message, "" if view.image_bgr is None else age_text(view.age_s))
        elif not view.boxes_fresh:
            text(cr, 8, height - 8, f"boxes: {view.boxes_message}", 13.0, ORANGE, bold=True, width=width - 16)
        else:
            cr.set_source_rgba(*BACKGROUND, 0.7)
            cr.rectangle(2, 2, 118, 21)
            cr.fill()
            caption(cr, f"CAMERA {age_text(view.age_s)}", TEXT)

    def _paint_picture(self, cr: Context, view: CameraView, scale: float) -> None:
        step = 2 if scale < _HALF_FROM else 1
        image = view.image_bgr
        assert image is not None, "the caller has looked"
        key = (view.frame_id, step)
        if key != self._shown or self._surface is None:
            self._shown = key
            small = image[::step, ::step]
            height, width = small.shape[:2]
            if self._pixels is None or self._pixels.shape[:2] != (height, width):
                self._pixels = np.zeros((height, width, 4), np.uint8)
                self._surface = cairo.ImageSurface.create_for_data(
                    self._pixels, cairo.FORMAT_RGB24, width, height, width * 4
                )
            self._surface.flush()
            self._pixels[:, :, :3] = small
            self._surface.mark_dirty()
        cr.save()
        cr.scale(scale * step, scale * step)
        cr.set_source_surface(self._surface, 0, 0)
        cr.get_source().set_filter(cairo.FILTER_BILINEAR)
        cr.paint()
        cr.restore()


def _paint_box(cr: Context, box: BoxView, scale: float, view: CameraView) -> None:
    colour = (YELLOW if box.is_target else SKY) if view.boxes_fresh else GREY
    unit = 1.0 / scale
    cr.set_source_rgb(*colour)
    cr.set_line_width((3.5 if box.is_target else 2.0) * unit)
    cr.set_dash([] if box.confirmed else [6 * unit, 5 * unit])
    cr.rectangle(box.left_px, box.top_px, box.right_px - box.left_px, box.bottom_px - box.top_px)
    cr.stroke()
    cr.set_dash([])
    size = (18.0 if box.is_target else 13.0) * unit
    cr.select_font_face(FONT, cairo.FONT_SLANT_NORMAL, cairo.FONT_WEIGHT_BOLD)
    cr.set_font_size(size)
    wide = cr.text_extents(box.label).x_advance
    x = max(min(box.left_px, view.width_px - wide - 4 * unit), 3 * unit)
    y = box.top_px - 5 * unit
    if y < size + 24 * unit:
        y = min(box.bottom_px + 1.2 * size, view.height_px - 8 * unit)
    cr.set_source_rgba(*BACKGROUND, 0.8)
    cr.rectangle(x - 3 * unit, y - size, wide + 6 * unit, 1.35 * size)
    cr.fill()
    text(cr, x, y, box.label, size, colour, bold=True)
