"""What went wrong is one line on standard error."""

from __future__ import annotations


def failed(message: str, code: int) -> int:
    """Tell it, and give the exit code back."""
    from rich.console import Console

    Console(stderr=True, soft_wrap=True).print(
        f"error: {message}",
        style="red",
        markup=False,
        highlight=False,
    )
    return code
