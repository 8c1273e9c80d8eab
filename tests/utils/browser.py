"""A real browser without a screen, for tests of the console: Debian's chromium, driven by selenium."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PATIENCE_S = 30.0
OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--hide-scrollbars",
)  # fmt: skip


def require_browser() -> None:
    pytest.importorskip("selenium", reason="selenium is not installed here (extra `dev`)")
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            pytest.skip(f"no {program} here; scripts/install-browser.sh installs it")


class Browser:
    """One window with a profile of its own. `width` and `height` are CSS pixels."""

    def __init__(
        self, pictures: Path, width: int = 1440, height: int = 900, dark: bool = True, phone: bool = False
    ) -> None:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        self.pictures = pictures
        self._profile = tempfile.mkdtemp(prefix="target_nav_browser_")
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium") or ""
        for option in (*OPTIONS, f"--user-data-dir={self._profile}", f"--window-size={width},{height}"):
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        self.shape(width, height, dark, phone)

    def shape(self, width: int, height: int, dark: bool = True, phone: bool = False) -> None:
        metrics = {"width": width, "height": height, "deviceScaleFactor": 2 if phone else 1, "mobile": phone}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})

    def open(self, address: str) -> None:
        # from page to page of one address only the part behind # would change
        self.driver.get("about:blank")
        self.driver.get(address)

    def find(self, css: str) -> Any:
        return self.driver.find_element("css selector", css)

    def text(self, css: str) -> str:
        return str(self.find(css).text)

    def click(self, css: str) -> None:
        self.find(css).click()

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def actions(self) -> Any:
        from selenium.webdriver import ActionChains

        return ActionChains(self.driver)

    def key(self, key: str) -> None:
        """On whatever has the focus, as a hand on the keyboard."""
        self.actions().send_keys(key).perform()

    def wait(self, condition: Callable[[], Any], what: str, patience_s: float = PATIENCE_S) -> Any:
        deadline_s = time.monotonic() + patience_s
        while not (found := condition()):
            assert time.monotonic() < deadline_s, f"waited {patience_s:g} s in vain: {what}; {self.state()}"
            time.sleep(0.03)
        return found

    def wait_text(self, css: str, text: str) -> None:
        self.wait(lambda: text in self.text(css), f"{css} says {text!r}")

    def state(self) -> str:
        """What the page says of itself, for a message."""
        return " | ".join(
            self.text(css) for css in ("#headline", "#story", "#banner", "#said", "#drive-says")
        )

    def errors(self) -> list[str]:
        """What the page's scripts complained about since the last call, a lost connection left out."""
        entries = self.driver.get_log("browser")
        return [
            e["message"]
            for e in entries
            if e["level"] == "SEVERE" and "WebSocket connection" not in e["message"]
        ]

    def shot(self, name: str) -> Path:
        path = self.pictures / f"{name}.png"
        self.driver.save_screenshot(str(path))
        return path

    def close(self) -> None:
        self.driver.quit()
        shutil.rmtree(self._profile, ignore_errors=True)
