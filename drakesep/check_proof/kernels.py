"""Integrals over time, of a product with a kernel too, for many functions at once.

A function is a column of intervals, one on each piece of time.
"""

from flint import arb, arb_mat

from .intervals import ZERO, Interval, Jet, magnitude


Column = list[Interval]
EVEN = arb(2) ** -40  # a kernel this close to symmetric about zero is taken as such


def integrated(x: list[Jet], lengths: list[arb]) -> list[Jet]:
    """Enclose the integral from 0 to any time of each piece."""
    total = [(ZERO, ZERO) for _ in x[0]]
    out = []
    for jet, h in zip(x, lengths, strict=True):
        steps = [(low * h, high * h) for low, high in jet]
        out.append(
            [
                (a + (l if l <= ZERO else l.min(ZERO)), b + (h if h >= ZERO else h.max(ZERO)))
                for (a, b), (l, h) in zip(total, steps, strict=True)
            ]
        )
        total = [(a + l, b + h) for (a, b), (l, h) in zip(total, steps, strict=True)]
    return out


class Columns:
    """Functions times the lengths of pieces, laid out for products with kernels."""

    def __init__(self, columns: list[Column], lengths: list[arb]):
        self.rows: list[list[Interval]] = []
        self.count = len(columns)
        for m, h in enumerate(lengths):
            self.rows.append([(c[m][0] * h, c[m][1] * h) for c in columns])
        low, high = [], []
        self.mixed: list[list[int]] = []
        sure_low, sure_high, mags = [], [], []
        for row in self.rows:
            mixed = []
            for j, (l, h) in enumerate(row):
                if l >= ZERO:
                    low.append((l, ZERO))
                    high.append((h, ZERO))
                    sure_low.append((l, ZERO))
                    sure_high.append((h, ZERO))
                    mags.append(h)
                elif h <= ZERO:
                    low.append((ZERO, l))
                    high.append((ZERO, h))
                    sure_low.append((ZERO, l))
                    sure_high.append((ZERO, h))
                    mags.append(-l)
                else:
                    mixed.append(j)
                    low.append((l.max(ZERO), l.min(ZERO)))
                    high.append((h.max(ZERO), h.min(ZERO)))
                    sure_low.append((ZERO, ZERO))
                    sure_high.append((ZERO, ZERO))
                    mags.append((-l).max(h))
            self.mixed.append(mixed)
        self.low_up, self.low_down = self._matrices(low)
        self.high_up, self.high_down = self._matrices(high)
        self.sure_low_up, self.sure_low_down = self._matrices(sure_low)
        self.sure_high_up, self.sure_high_down = self._matrices(sure_high)
        self.magnitudes = arb_mat(len(lengths), self.count, mags)

    def _matrices(self, parts: list[tuple[arb, arb]]) -> tuple[arb_mat, arb_mat]:
        shape = len(self.rows), self.count
        return (
            arb_mat(*shape, [up for up, _ in parts]),
            arb_mat(*shape, [down for _, down in parts]),
        )


class Kernel:
    """A lower triangle of intervals: row n times pieces up to n."""

    def __init__(self, rows: list[list[Interval]]):
        size = len(rows)
        entries: dict[str, list[list[arb]]] = {}

        def put(name: str, n: int, m: int, x: arb) -> None:
            if name not in entries:
                entries[name] = [[ZERO] * size for _ in rows]
            entries[name][n][m] = x

        self.size = size
        self.mixed: list[tuple[int, int, arb, arb]] = []
        for n, row in enumerate(rows):
            for m, (low, high) in enumerate(row):
                if low >= ZERO:
                    put("up low", n, m, low)
                    put("up high", n, m, high)
                elif high <= ZERO:
                    put("down low", n, m, low)
                    put("down high", n, m, high)
                elif abs(low + high) <= EVEN * high:
                    put("even", n, m, magnitude((low, high)))
                else:
                    low, high = low.min(ZERO), high.max(ZERO)
                    put("mixed low", n, m, low)
                    put("mixed high", n, m, high)
                    self.mixed.append((n, m, low, high))
        self.parts = {name: arb_mat(part) for name, part in entries.items()}

    def __call__(self, x: Columns) -> list[Column]:
        """Return the sums of products, exact but for rounding: a column for each."""
        lows, highs = [], []
        for name, part in self.parts.items():
            if name == "up low":
                highs.append(part * x.high_down)
                lows.append(part * x.low_up)
            elif name == "up high":
                highs.append(part * x.high_up)
                lows.append(part * x.low_down)
            elif name == "down low":
                highs.append(part * x.low_down)
                lows.append(part * x.high_up)
            elif name == "down high":
                highs.append(part * x.low_up)
                lows.append(part * x.high_down)
            elif name == "even":
                most = part * x.magnitudes
                highs.append(most)
                lows.append(-most)
            elif name == "mixed low":
                highs.append(part * x.sure_low_down)
                lows.append(part * x.sure_high_up)
            else:
                highs.append(part * x.sure_high_up)
                lows.append(part * x.sure_low_down)
        low, high = lows[0], highs[0]
        for other in lows[1:]:
            low = low + other
        for other in highs[1:]:
            high = high + other
        low_rows, high_rows = low.tolist(), high.tolist()
        for n, m, l, h in self.mixed:
            low_row, high_row, row = low_rows[n], high_rows[n], x.rows[m]
            for j in x.mixed[m]:
                a, b = row[j]
                low_row[j] += (l * b).min(h * a)
                high_row[j] += (l * a).max(h * b)
        return [
            list(zip(lows, highs, strict=True))
            for lows, highs in zip(
                zip(*low_rows, strict=True), zip(*high_rows, strict=True), strict=True
            )
        ]


def difference_kernel(x: Column, ended: int) -> Kernel:
    """Return x(t) - x(s) for t on a piece and s on one not after it (Eq. 15).

    From piece `ended` on x is constant, though not known exactly.
    """
    rows = []
    for n, (low, high) in enumerate(x):
        row = [(low - x[m][1], high - x[m][0]) for m in range(n + 1)]
        if n >= ended:
            row[ended:] = [(ZERO, ZERO)] * (n + 1 - ended)
        rows.append(row)
    return Kernel(rows)
