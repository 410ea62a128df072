"""Have reports say what ``docs/certificate.json`` counts: what the certificate's command does at its end."""

import json

import typer

from benchmarks.certificate.code import INSTALLED, ROOT
from hybrid.diagnosis.track_record.certified import install

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main() -> None:
    """Write the numbers that are installed with the program, of the certificate in the documentation."""
    numbers = json.loads((ROOT / "docs" / "certificate.json").read_text(encoding="utf-8"))
    print(install(numbers, ROOT / INSTALLED))


if __name__ == "__main__":
    app()
