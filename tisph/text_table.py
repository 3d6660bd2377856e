"""Tables in Markdown that are also aligned as plain text."""

from collections.abc import Sequence


def format_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table of ``header`` and ``rows`` of equally many texts."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    return "\n".join([format_header(header, widths), *(format_row(row, widths) for row in rows)])


def format_header(header: Sequence[str], widths: Sequence[int]) -> str:
    """Return the header and the rule below it, for columns of ``widths`` characters: the first left-aligned."""
    first, *others = ("-" * (width + 1) for width in widths)
    rule = "|".join(["", f":{first}", *(f"{dashes}:" for dashes in others), ""])
    return f"{format_row(header, widths)}\n{rule}"


def format_row(cells: Sequence[str], widths: Sequence[int]) -> str:
    """Return one line, for a table that is printed while its numbers are still being computed."""
    first, *others = zip(cells, widths, strict=True)
    padded = [first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in others)]
    return f"| {' | '.join(padded)} |"
