"""All numbers of the papers' tables; `python -m tests.papers.numbers` writes numbers.json anew."""

from pathlib import Path

from cogging.papers.reproduction import PAPERS
from tests.fixtures.reproduced import reproduced

FILE = Path(__file__).with_name("numbers.json")


def numbers(document):
    """Return the simulated numbers of a result file by table, to five digits."""
    return {table["id"]: [float(f"{row['simulated']:.5g}") for row in table["rows"]] for table in document["tables"]}


def text(documents):
    """Return the text of numbers.json for result files by paper, one line a table."""
    parts = [
        f' "{paper}": {{\n' + ",\n".join(f'  "{name}": {row}' for name, row in numbers(document).items()) + "\n }"
        for paper, document in documents.items()
    ]
    return "{\n" + ",\n".join(parts).replace("inf", "Infinity").replace("nan", "NaN") + "\n}\n"


if __name__ == "__main__":
    FILE.write_text(text({paper: reproduced(paper).to_dict() for paper in PAPERS}))
    print(f"{FILE} written")
