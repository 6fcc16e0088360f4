"""What users say, and which page of the site answers it; what the site's search finds in a browser.

The words are those of titles of issues of kindred projects.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

#: By word: the pages of which one has to be among the first three that are found.
SAID: dict[str, tuple[str, ...]] = {
    "hysteresis": ("hysteresis",),
    "hysteresis loop": ("hysteresis",),
    "backlash": ("hysteresis",),
    "stiction": ("hysteresis",),
    "friction": ("hysteresis",),
    "current": ("your-log",),
    "voltage": ("your-log",),
    "torque": ("control",),
    "force control": ("control",),
    "haptic": ("control",),
    "stm32": ("stm32",),
    "Arduino": ("stm32",),
    "microcontroller": ("stm32",),
    "interrupt": ("stm32",),
    "dSPACE": ("export-targets",),
    "simulink": ("export-targets",),
    "ROS": ("export-targets",),
    "FMU": ("export-targets",),
    "matlab file": ("formats",),
    "csv": ("formats",),
    "labview": ("formats",),
    "bingham": ("laws",),
    "yield stress": ("laws",),
    "magnetorheological": ("laws",),
    "bouc-wen": ("memory",),
    "temperature": ("memory",),
    "delay": ("lag",),
    "neural network": ("networks",),
    "confidence interval": ("bands",),
    "accuracy": ("trust",),
    "validation": ("trust",),
    "drift": ("recalibrate",),
    "real time": ("live",),
    "hardware in the loop": ("rig-udp",),
    "simulation": ("twin",),
    "sampling rate": ("your-log",),
    "damper": ("damper",),
    "gui": ("app",),
    "pdf": ("report",),
    "windows": ("install",),
    # Words that were tried blind, after the others were found.
    "sample time": ("your-log", "lag"),
    "ram": ("stm32",),
    "misra": ("export",),
    "saturation": ("good-log",),
    "cogging": ("memory",),
    "overfitting": ("trust",),
    "viscosity": ("laws",),
    "excel": ("formats",),
    "ros bag": ("formats",),
    "PID": ("control",),
    "batch": ("fleets",),
    "jupyter": ("damper",),
    "docker": ("install",),
    "encoder": ("your-log",),
    "decimal comma": ("your-log", "formats"),
    "torque sensor": ("your-log", "control"),
    "flash": ("stm32",),
    "float32": ("export",),
    "ageing": ("recalibrate",),
    "noise": ("good-log", "your-log"),
    "eddy current": ("lag",),
    "phase lag": ("lag",),
    "gearbox": ("hysteresis", "memory"),
    "rheometer": ("report",),
    "missing values": ("your-log",),
    "low-pass filter": ("your-log",),
    "negative torque": ("your-log",),
    "breakaway": ("hysteresis",),
    "jitter": ("live",),
    "sedimentation": ("recalibrate",),
    "Raspberry Pi": ("export",),
    "licence": ("install",),
    "cite": ("install",),
    "sign of force": ("your-log",),
}


def first_pages(page: Any, site: Path, word: str, most: int = 3) -> list[str]:
    """The first pages that the built site's search finds for a word, by their names; none where it finds nothing.

    Args:
        page: a page of a browser.
        site: folder of the built site.
        word: what is searched.
        most: how many pages.
    """
    address = (site / "search.html").as_uri()
    if page.url != address:
        page.goto(address)
    # As the page does with a word of its address: a load of the page and of its index takes longer than a search.
    page.evaluate(
        "word => { document.querySelector('#search-results').replaceChildren();"
        " Search.performSearch(word); }",
        word,
    )
    # The search writes its summary after the last result, also where there is none.
    page.wait_for_function(
        "document.querySelector('#search-results .search-summary')?.textContent", timeout=20_000
    )
    links = page.locator("#search-results li a").all()[:most]
    return [Path(urlsplit(link.get_attribute("href")).path).stem for link in links]
