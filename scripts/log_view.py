"""Reads what PETSc counted in a run: the table that `-log_view :FILE:ascii_csv` writes."""
import csv
from collections import defaultdict

FIGURES = {"seconds": "Time", "messages": "Num Messages", "bytes": "Message Length", "reductions": "Num Reductions"}


class LogView:
    """Sums over ranks by stage and event; a stage's own sum is its event 'summary'.

    PETSc counts a message where it is sent and where it is received, so messages and bytes are halved here.
    """

    def __init__(self, path):
        self.ranks = 0
        self.sums = defaultdict(lambda: dict.fromkeys(FIGURES, 0.0))
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                self.ranks = max(self.ranks, int(row["Rank"]) + 1)
                sums = self.sums[row["Stage Name"], row["Event Name"]]
                for name, column in FIGURES.items():
                    sums[name] += float(row[column]) / (2 if name in ("messages", "bytes") else 1)

    def total(self, figure, event="summary", stage="level"):
        """A figure of an event, added over ranks and over the stages whose name begins with `stage`."""
        return sum(sums[figure] for (name, kind), sums in self.sums.items() if kind == event and name.startswith(stage))
