"""Colours, sizes and the widgets' style sheet.

Colours are Okabe and Ito's ("Color Universal Design", 2008), told apart with every kind of colour vision; and nothing
is said by colour alone: marks, shapes and words say it too. Sizes are for 800x480 on 5 to 7 inches, read from two
metres and pressed with a thumb.
"""

from __future__ import annotations

Colour = tuple[float, float, float]


def _rgb(code: str) -> Colour:
    return int(code[1:3], 16) / 255.0, int(code[3:5], 16) / 255.0, int(code[5:7], 16) / 255.0


BACKGROUND, PANE, LINE, GREY, TEXT = map(_rgb, ("#0d1117", "#171d26", "#39424e", "#8b96a3", "#f2f5f7"))
BLUE, SKY, ORANGE, VERMILION = map(_rgb, ("#0072b2", "#56b4e9", "#e69f00", "#d55e00"))
GREEN, YELLOW, PURPLE = map(_rgb, ("#009e73", "#f0e442", "#cc79a7"))

STATUS_COLOUR: dict[str, Colour] = {"INVALID": GREY, "RUNNING": SKY, "SUCCESS": GREEN, "FAILURE": ORANGE}
LEVEL_COLOUR: dict[str, Colour] = {"info": TEXT, "good": GREEN, "warn": YELLOW, "bad": ORANGE}
LEVEL_MARK = {"info": "·", "good": "✔", "warn": "!", "bad": "✘"}

WIDTH, HEIGHT = 800, 480
BAR_HEIGHT, STRIP_HEIGHT, NAV_HEIGHT, SIDE_WIDTH = 56, 30, 54, 150

FONT = "DejaVu Sans"

CSS = b"""
* { font-family: "DejaVu Sans"; }
window { background: #0d1117; color: #f2f5f7; }
label { color: #f2f5f7; font-size: 15px; }
label.dim { color: #b3bcc6; font-size: 13px; }
label.big { font-size: 24px; font-weight: bold; }
label.wrong { color: #e69f00; font-weight: bold; }
button { background: #26303c; color: #f2f5f7; border: 2px solid #39424e; border-radius: 6px; padding: 2px;
         font-size: 15px; font-weight: bold; text-shadow: none; box-shadow: none; min-height: 44px; }
button label { font-size: 15px; font-weight: bold; }
button:focus { border-color: #f0e442; }
button:active { background: #56b4e9; color: #0d1117; }
button:disabled, button:disabled label { color: #6b7683; }
button.page { min-height: 46px; padding: 0px; border-radius: 4px; }
button.page label { font-size: 13px; }
button.page.chosen { background: #56b4e9; border-color: #56b4e9; }
button.page.chosen label { color: #0d1117; }
button.page:focus { border-color: #f0e442; }
button.go { background: #0072b2; border-color: #56b4e9; }
button.go label { font-size: 30px; }
button.stop { background: #d55e00; border-color: #ffffff; }
button.stop label { font-size: 34px; color: #ffffff; }
button.go:focus, button.stop:focus { border-color: #f0e442; }
button.chosen { background: #56b4e9; }
button.chosen label { color: #0d1117; }
button.row { padding: 2px 8px; border-width: 1px; min-height: 40px; }
button.row label { font-size: 14px; font-weight: normal; }
button.key label { font-size: 20px; }
box.side { background: #171d26; }
scrolledwindow, viewport, list, notebook, notebook stack, stack { background: #0d1117; border: none; }
scrollbar slider { min-width: 14px; background: #56b4e9; border-radius: 4px; }
scrollbar { background: #171d26; }
"""
