"""A PDF can be read aloud: matplotlib draws pages, and its groups with the id of an element are that element's content.

Whatever is drawn outside of all elements is an artifact, which a reader skips (PDF 1.4, sections 9.5 to 9.7).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.backends import backend_pdf
from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_pdf import Name

from erclutch.report.plots.paper_style import settle

_backend: Any = backend_pdf
_DPI = 150  # of maps; all else is lines


@dataclass
class TaggedElement:
    """A part of the document.

    Attributes:
        tag: H1, H2, P, Figure, Table, TR, TH or TD.
        parent: its number among the elements; None: the document.
        alt: what a figure shows, in words.
        content: (page, number of the marked content in the page).
    """

    tag: str
    parent: int | None
    alt: str
    content: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])


class _TaggedFile(_backend.PdfFile):
    """A file whose catalog and pages say that there is a structure."""

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        self.tree: Any = None
        self.marked: list[list[int]] = []  # of each page the elements of its contents
        super().__init__(path, metadata=about)  # pyright: ignore[reportUnknownMemberType]
        self.fh.write(f"%/Creator ({about['Creator']})\n".encode())  # where `may_write_report` looks for it

    def writeObject(self, object: Any, contents: Any) -> None:
        entries: Any = contents
        kind = entries.get("Type") if hasattr(entries, "get") else None
        if kind == Name("Catalog"):
            self.tree = self.reserveObject("structure")
            entries |= {"MarkInfo": {"Marked": True}, "Lang": "en", "StructTreeRoot": self.tree}
            entries |= {"ViewerPreferences": {"DisplayDocTitle": True}}
        elif kind == Name("Page"):
            entries |= {"StructParents": len(self.marked), "Tabs": Name("S")}
            self.marked.append([])
        super().writeObject(object, contents)  # pyright: ignore[reportUnknownMemberType]


class _TaggedRenderer(_backend.RendererPdf):
    """The renderer of one page: at each moment it draws one element, or an artifact."""

    def __init__(self, pages: TaggedPages, height: float, width: float) -> None:
        super().__init__(pages.file, _DPI, height, width)  # pyright: ignore[reportUnknownMemberType]
        self._pages, self._open = pages, [None]
        self._begin()

    def open_group(self, s: str, gid: str | None = None) -> None:
        """An element begins, or goes on inside another one."""
        self._end_and_begin(gid if gid in self._pages.numbers else self._open[-1], opens=True)

    def close_group(self, s: str) -> None:
        """What was drawn before goes on."""
        self._end_and_begin(self._open[-2], opens=False)

    def finalize(self) -> None:
        super().finalize()  # pyright: ignore[reportUnknownMemberType]
        self.file.write(b"EMC\n")

    def _end_and_begin(self, gid: Any, *, opens: bool) -> None:
        changes = gid != self._open[-1]
        if opens:
            self._open.append(gid)
        else:
            self._open.pop()
        if changes:
            self.file.write(b"EMC\n")
            self._begin()

    def _begin(self) -> None:
        gid = self._open[-1]
        if gid is None:
            self.file.write(b"/Artifact BMC\n")
            return
        number, page = self._pages.numbers[gid], len(self.file.marked) - 1
        marked, element = self.file.marked[page], self._pages.elements[number]
        element.content.append((page, len(marked)))
        self.file.write(f"/{element.tag} <</MCID {len(marked)}>> BDC\n".encode())
        marked.append(number)


class TaggedPages:
    """Pages of a PDF with their structure, in the order of reading.

    Args:
        path: the file.
        about: its metadata.
    """

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        self.file = _TaggedFile(path, about)
        self.elements: list[TaggedElement] = []
        self.numbers: dict[str, int] = {}

    def add(self, tag: str, parent: str | None = None, alt: str = "") -> str:
        """A new element, after the others: the ``gid`` of what draws its content."""
        number = len(self.elements)
        self.elements.append(TaggedElement(tag, None if parent is None else self.numbers[parent], alt))
        self.numbers[f"element-{number}"] = number
        return f"element-{number}"

    def save(self, figure: Any) -> None:
        """Draw a figure as the next page."""
        figure.dpi = 72  # points in an inch
        settle(figure)
        width, height = figure.get_size_inches()
        self.file.newPage(width, height)
        renderer: Any = MixedModeRenderer(figure, width, height, _DPI, _TaggedRenderer(self, height, width))
        figure.draw(renderer)
        renderer.finalize()
        self.file.endStream()

    def close(self, *, whole: bool) -> None:
        """Write what is left of the file, if all pages are there."""
        if whole:
            self._write_structure()
            self.file.finalize()
        self.file.close()

    def _write_structure(self) -> None:
        file = self.file
        document, parents = file.reserveObject("document"), file.reserveObject("parents")
        made = [file.reserveObject("element") for _ in self.elements]
        kids: dict[int | None, list[Any]] = {}
        for own, element in zip(made, self.elements, strict=True):
            kids.setdefault(element.parent, []).append(own)
        for number, (own, element) in enumerate(zip(made, self.elements, strict=True)):
            content = [{"Type": Name("MCR"), "Pg": file.pageList[page], "MCID": mark} for page, mark in element.content]
            body = {"Type": Name("StructElem"), "S": Name(element.tag), "K": [*content, *kids.get(number, [])]}
            body["P"] = document if element.parent is None else made[element.parent]
            file.writeObject(own, body | ({"Alt": element.alt} if element.alt else {}))
        nums = [part for page, marks in enumerate(file.marked) for part in (page, [made[k] for k in marks])]
        file.writeObject(parents, {"Nums": nums})
        whole = {"Type": Name("StructElem"), "S": Name("Document"), "P": file.tree, "K": kids.get(None, [])}
        file.writeObject(document, whole)
        root = {"Type": Name("StructTreeRoot"), "K": [document], "ParentTree": parents}
        file.writeObject(file.tree, root | {"ParentTreeNextKey": len(file.marked)})
