"""Print: packages, labels, book covers and screens, laid out as they are, with invented letters."""

from __future__ import annotations

import numpy as np

from .glyphs import alphabet, barcode, text_line, word_picture
from .grid import Grid, Layers, flat_layers, step
from .wear import rubbed

#: Reflectance of white board under a print, and of ink, linear.
BOARD, INK = np.array((0.72, 0.69, 0.63), np.float32), np.array((0.02, 0.02, 0.022), np.float32)
#: Size of a bar code [m]: EAN-13 at its nominal size without quiet zones is 31.35 x 22.85 mm (GS1).
BARCODE = (0.0314, 0.0229)
#: Heights of letters [m]: small print is about 1.2 mm (EU 1169/2011 asks for x-heights of that), body text 2 mm.
SMALL, BODY = 0.0017, 0.0026
#: Width of the strip that is rubbed along edges of a worn package [m].
RUBBED = 0.0012


class Sheet:
    """A print in the making: what is drawn on it is placed in metres from its lower left corner."""

    def __init__(self, grid: Grid, colour: np.ndarray) -> None:
        self.grid, self.rng = grid, grid.rng
        self.colour = flat_layers(grid, colour).colour
        weight = float(grid.rng.uniform(0.09, 0.2))
        self.display, self.body = alphabet(grid.rng, weight), alphabet(grid.rng, 0.1)

    def rectangle(self, x0: float, y0: float, x1: float, y1: float, colour: np.ndarray) -> None:
        """Fill a rectangle, with edges at fractions of texels."""
        grid = self.grid
        wide, high = grid.texel
        across = np.clip(np.minimum(grid.x - x0, x1 - grid.x) / wide + 0.5, 0.0, 1.0)
        up = np.clip(np.minimum(grid.y - y0, y1 - grid.y) / high + 0.5, 0.0, 1.0)
        columns, rows = _range(across[0] > 0), _range(up[:, 0] > 0)
        self.ink((across[:, columns] * up[rows]).astype(np.float32), colour, rows, columns)

    def ellipse(self, x: float, y: float, half_x: float, half_y: float, colour: np.ndarray, inner: float = 0.0) -> None:
        """Fill an ellipse, or a ring from `inner` of its size on."""
        soft = max(self.grid.texel) / min(half_x, half_y)
        across, up = (self.grid.x - x) / half_x, (self.grid.y - y) / half_y
        columns, rows = _range(np.abs(across[0]) < 1 + soft), _range(np.abs(up[:, 0]) < 1 + soft)
        r = np.hypot(across[:, columns], up[rows])
        amount = np.clip((1.0 - r) / soft + 0.5, 0.0, 1.0)
        if inner:
            amount = amount * np.clip((r - inner) / soft + 0.5, 0.0, 1.0)
        self.ink(amount.astype(np.float32), colour, rows, columns)

    def repeat(self, x: float, width: float, height: float) -> None:
        """Print what is in the lower left corner once more at a place along x."""
        columns, first = round(width / self.grid.texel[0]), round(x / self.grid.texel[0])
        columns, rows = min(columns, self.grid.columns - first), round(height / self.grid.texel[1])
        self.colour[:rows, first : first + columns] = self.colour[:rows, :columns]

    def reading(self, x: float, y: float, width: float, height: float) -> np.ndarray:
        """Return ink that reads on what a box shows: dark on light and light on dark."""
        columns = slice(max(0, int(x / self.grid.texel[0])), int((x + width) / self.grid.texel[0]) + 1)
        rows = slice(max(0, int(y / self.grid.texel[1])), int((y + height) / self.grid.texel[1]) + 1)
        region = self.colour[rows, columns].reshape(-1, 3)
        return INK if not len(region) or float(region.mean(0) @ (0.2126, 0.7152, 0.0722)) > 0.18 else BOARD

    def word(self, x: float, y: float, width: float, height: float, colour: np.ndarray | None, length: int) -> None:
        """Set one word of display letters in a box, centred; by default in ink that reads there."""
        colour = self.reading(x, y, width, height) if colour is None else colour
        picture = word_picture(self.rng, self.display, 40, length, capitals=bool(self.rng.random() < 0.5))
        scale = min(width / picture.shape[1], height / picture.shape[0])
        self.stamp(picture, x + (width - scale * picture.shape[1]) / 2, y, scale, colour)

    def text(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        size: float,
        colour: np.ndarray | None,
        ragged: float = 0.2,
    ) -> None:
        """Set lines of small text in a box, from its top; by default in ink that reads there."""
        colour = self.reading(x, y, width, height) if colour is None else colour
        pitch = 1.5 * size
        for number in range(int(height / pitch)):
            line_width = width * (1.0 - ragged * self.rng.random())
            columns = max(1, round(line_width / size * 12))
            line = text_line(self.rng, self.body, 12, columns)
            self.stamp(line, x, y + height - (number + 1) * pitch, size / 12, colour)

    def code(self, x: float, y: float, scale: float = 1.0) -> None:
        """Print a bar code on white with its lower left corner at a place."""
        wide, high = BARCODE[0] * scale, BARCODE[1] * scale
        self.rectangle(x - 0.003, y - 0.0015, x + wide + 0.003, y + high + 0.0015, BOARD * 1.1)
        bars = np.tile(barcode(self.rng), (2, 1))
        self.stamp(bars, x, y + 0.12 * high, wide / bars.shape[1], INK, high * 0.88 / 2)
        line = text_line(self.rng, self.body, 12, 150, capitals=True)
        self.stamp(line, x, y, wide / line.shape[1], INK)

    def stamp(
        self, picture: np.ndarray, x: float, y: float, pixel: float, colour: np.ndarray, pixel_y: float | None = None
    ) -> None:
        """Print a picture, (h, w) coverage with its first row on top, with its lower left corner at a place [m]."""
        wide, high = self.grid.texel
        pixel_y = pixel if pixel_y is None else pixel_y
        left, right = x / wide, (x + picture.shape[1] * pixel) / wide
        low, top = y / high, (y + picture.shape[0] * pixel_y) / high
        first, last = max(0, int(np.floor(left))), min(self.grid.columns, int(np.ceil(right)))
        below, above = max(0, int(np.floor(low))), min(self.grid.rows, int(np.ceil(top)))
        if first >= last or below >= above:
            return
        # Each texel is the mean of what it covers: sums up to its edges, subtracted.
        rows = _cumulated(
            picture[::-1], np.clip((np.arange(below, above + 1) * high - y) / pixel_y, 0, picture.shape[0])
        )
        cells = _cumulated(rows.T, np.clip((np.arange(first, last + 1) * wide - x) / pixel, 0, picture.shape[1])).T
        amount = np.clip(cells * (pixel_y / high) * (pixel / wide), 0.0, 1.0)
        self.ink(amount, colour, slice(below, above), slice(first, last))

    def ink(self, amount: np.ndarray, colour: np.ndarray, rows: slice, columns: slice) -> None:
        """Lay an amount (h, w) of a colour over some rows and columns."""
        part = self.colour[rows, columns]
        part += amount[..., None] * (np.asarray(colour, np.float32) - part)


def _range(inside: np.ndarray) -> slice:
    """Return the range of the true elements of a row in which they follow each other."""
    places = np.flatnonzero(inside)
    return slice(int(places[0]), int(places[-1]) + 1) if len(places) else slice(0, 0)


def _cumulated(picture: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the sums of a picture's rows between edges at fractions of rows."""
    sums = np.concatenate([np.zeros((1, picture.shape[1]), np.float32), np.cumsum(picture, axis=0)])
    low = np.minimum(np.floor(edges).astype(int), len(picture) - 1)
    at = sums[low] + (edges - low)[:, None].astype(np.float32) * picture[low]
    return np.diff(at, axis=0)


def carton(grid: Grid, colours: np.ndarray) -> Layers:
    """Carton, unfolded: its sides side by side (front, right, back, left), its top above the front.

    The picture is 2 (w + d) wide and h + d high. Its layout is d over h.
    """
    sheet = Sheet(grid, colours[0])
    depth = grid.height * grid.layout[0] / (1.0 + grid.layout[0])
    width, height = grid.width / 2 - depth, grid.height - depth
    lefts = np.cumsum([0.0, width, depth, width])
    front_style = grid.rng.random()
    _front(sheet, 0.0, 0.0, width, height, colours, front_style)
    sheet.repeat(lefts[2], width, height)
    for number, start in enumerate((lefts[1], lefts[3])):
        _side(sheet, start, 0.0, depth, height, colours, code=number == 0)
    sheet.rectangle(0.0, height, width, height + depth, colours[0])
    if width > 0.03 and depth > 0.012:
        sheet.word(0.1 * width, height + 0.35 * depth, 0.8 * width, 0.3 * depth, colours[-1], 6)
    edges = np.concatenate([lefts, [grid.width]])
    fold_x = np.abs(grid.x - edges[:, None]).min(0)[None]
    fold_y = np.minimum(np.minimum(grid.y, np.abs(grid.y - height)), grid.height - grid.y)
    colour = rubbed(grid, sheet.colour, np.minimum(fold_x, fold_y), BOARD, RUBBED)
    return printed(grid, colour)


def label(grid: Grid, colours: np.ndarray) -> Layers:
    """Label around a can or a bottle: twice a front, with small print and a bar code between."""
    sheet = Sheet(grid, colours[0])
    quarter, style = grid.width / 4, grid.rng.random()
    _front(sheet, 0.0, 0.0, quarter * 1.1, grid.height, colours, style)
    sheet.repeat(2 * quarter, 1.1 * quarter, grid.height)
    _side(sheet, 1.15 * quarter, 0.0, 0.75 * quarter, grid.height, colours, code=True)
    _side(sheet, 3.15 * quarter, 0.0, 0.75 * quarter, grid.height, colours, code=False)
    band = grid.rng.uniform(0.02, 0.08) * grid.height
    for low in (0.0, grid.height - band):
        sheet.rectangle(0.0, low, grid.width, low + band, colours[min(2, len(colours) - 1)])
    return printed(grid, sheet.colour)


def cover(grid: Grid, colours: np.ndarray) -> Layers:
    """Cover of a book, opened flat: back, spine, and front. Its layout is the spine over the whole width."""
    sheet = Sheet(grid, colours[0])
    spine = grid.layout[0] * grid.width
    side = (grid.width - spine) / 2
    _front(sheet, side + spine, 0.0, side, grid.height, colours, grid.rng.random(), title=True)
    if grid.rng.random() < 0.7:
        sheet.text(0.15 * side, 0.35 * grid.height, 0.7 * side, 0.45 * grid.height, BODY, _contrast(colours))
        sheet.code(0.55 * side, 0.06 * grid.height, min(1.0, 0.35 * side / BARCODE[0]))
    _spine(sheet, side, spine, colours)
    edge_x = np.minimum(np.minimum(grid.x, grid.width - grid.x), np.abs(np.abs(grid.x - grid.width / 2) - spine / 2))
    edge = np.minimum(edge_x, np.minimum(grid.y, grid.height - grid.y))
    return printed(grid, rubbed(grid, sheet.colour, edge, BOARD, RUBBED))


def _spine(sheet: Sheet, start: float, width: float, colours: np.ndarray) -> None:
    """Print a spine: a title that runs up it, and bands."""
    grid, height = sheet.grid, sheet.grid.height
    if sheet.rng.random() < 0.5:
        sheet.rectangle(start, 0.0, start + width, height, colours[1])
    for place in sheet.rng.uniform(0.04, 0.16, 2):
        for low in (place * height, (1.0 - place) * height):
            sheet.rectangle(start, low, start + width, low + 0.0012, colours[-1])
    picture = np.rot90(word_picture(sheet.rng, sheet.display, 40, int(sheet.rng.integers(7, 14)), capitals=True))
    size = min(0.5 * width / picture.shape[1], 0.6 * height / picture.shape[0])
    ink = sheet.reading(start, 0.2 * height, width, 0.6 * height)
    sheet.stamp(picture, start + (width - size * picture.shape[1]) / 2, 0.2 * grid.height, size, ink)


def _front(
    sheet: Sheet,
    x: float,
    y: float,
    width: float,
    height: float,
    colours: np.ndarray,
    style: float,
    title: bool = False,
) -> None:
    """Print a front: a field, a picture of simple shapes, a name, and a line or two below it."""
    rng, main, accent = sheet.rng, colours[1], colours[min(2, len(colours) - 1)]
    if style < 0.35:
        sheet.rectangle(x, y, x + width, y + 0.42 * height, main)
    elif style < 0.7:
        sheet.rectangle(x, y + 0.58 * height, x + width, y + height, main)
    else:
        sheet.rectangle(x + 0.06 * width, y + 0.05 * height, x + 0.94 * width, y + 0.95 * height, main)
        sheet.rectangle(x + 0.09 * width, y + 0.07 * height, x + 0.91 * width, y + 0.93 * height, colours[0])
    box = (x + 0.12 * width, y + 0.2 * height, 0.76 * width, 0.36 * height)
    draw_picture(sheet, rng, *box, (main, accent, colours[0]))
    high = height * (0.14 if title else 0.16)
    sheet.word(x + 0.1 * width, y + 0.68 * height, 0.8 * width, high, None, int(rng.integers(4, 8)))
    sheet.word(x + 0.2 * width, y + 0.61 * height, 0.6 * width, 0.035 * height, None, int(rng.integers(8, 14)))
    if title:
        sheet.word(x + 0.25 * width, y + 0.09 * height, 0.5 * width, 0.03 * height, None, int(rng.integers(8, 13)))
    else:
        sheet.text(x + 0.12 * width, y + 0.08 * height, 0.5 * width, 0.06 * height, BODY, None)


def draw_picture(
    sheet: Sheet,
    rng: np.random.Generator,
    x: float,
    y: float,
    width: float,
    height: float,
    colours: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    """Draw what a front shows into a box: fruit, a sun over hills, stripes, or a field of dots."""
    kind = int(rng.integers(4))
    if kind == 0:
        for _ in range(int(rng.integers(3, 7))):
            radius = min(width, height) * rng.uniform(0.15, 0.3)
            place = x + rng.uniform(radius, width - radius), y + rng.uniform(radius, height - radius)
            paint = colours[int(rng.integers(2))] * rng.uniform(0.8, 1.3)
            sheet.ellipse(*place, radius, radius * rng.uniform(0.6, 1.0), paint)
            sheet.ellipse(place[0] - radius / 3, place[1] + radius / 3, radius / 4, radius / 7, 1.4 * paint + 0.1)
    elif kind == 1:
        sheet.ellipse(x + rng.uniform(0.3, 0.7) * width, y + 0.65 * height, 0.2 * height, 0.2 * height, colours[1])
        for number in range(int(rng.integers(2, 4))):
            half = width * rng.uniform(0.2, 0.34)
            place = x + rng.uniform(half, width - half)
            sheet.ellipse(place, y, half, height * rng.uniform(0.3, 0.6), colours[number % 2] * rng.uniform(0.6, 1.1))
    elif kind == 2:
        count, turn = int(rng.integers(3, 8)), rng.random() < 0.5
        for number in range(count):
            low, step_ = number / count, 0.6 / count
            box = (x + low * width, y, x + (low + step_) * width, y + height * rng.uniform(0.4, 1.0))
            if turn:
                box = (x, y + low * height, x + width * rng.uniform(0.4, 1.0), y + (low + step_) * height)
            sheet.rectangle(*box, colours[number % 2])
    else:
        size = height / int(rng.integers(3, 7))
        for row in range(int(height / size)):
            for column in range(int(width / size)):
                half = size * rng.uniform(0.15, 0.45)
                place = x + (column + 0.5) * size, y + (row + 0.5) * size
                sheet.ellipse(*place, half, half, colours[int(rng.integers(2))])


def _side(sheet: Sheet, x: float, y: float, width: float, height: float, colours: np.ndarray, code: bool) -> None:
    """Print a side: a heading, a box of small print, a table with lines, and a bar code."""
    ink, inner = _contrast(colours), 0.84 * width
    left = x + 0.08 * width
    sheet.word(left, y + 0.88 * height, inner, 0.05 * height, ink, 7)
    sheet.text(left, y + 0.60 * height, inner, 0.24 * height, SMALL, ink)
    table = 0.33 * height if not code else 0.2 * height
    low = y + 0.55 * height - table
    for number in range(int(table / 0.004) + 1):
        sheet.rectangle(left, low + 0.004 * number, left + inner, low + 0.004 * number + 0.0002, ink)
    sheet.text(left, low, 0.5 * inner, table, 0.0026 / 1.5 * 1.54, ink, 0.5)
    if code:
        scale = min(1.0, inner / (BARCODE[0] + 0.006), 0.28 * height / BARCODE[1])
        sheet.code(left + (inner - scale * BARCODE[0]) / 2, y + 0.05 * height, scale)


def screen(grid: Grid, colours: np.ndarray) -> Layers:
    """Front of a phone: dark glass with a black rim, off, with finger marks."""
    layers = flat_layers(grid, colours[0])
    smear = step(0.2, 1.6, grid.noise((0.010, 0.03), 3))
    streak = step(0.8, 2.0, grid.noise((0.004, 0.04), 2))
    return Layers(layers.colour * (1.0 + 0.5 * smear)[..., None], 1.0 + 5.0 * smear + 4.0 * streak, layers.height)


def _contrast(colours: np.ndarray) -> np.ndarray:
    """Return ink that reads on the first colour: dark on light and light on dark."""
    return INK if float(colours[0] @ (0.2126, 0.7152, 0.0722)) > 0.2 else BOARD


def printed(grid: Grid, colour: np.ndarray) -> Layers:
    """Return the layers of a print of these colours, (h, w, 3): on fibres, with ink that is smoother than paper."""
    fibre = grid.noise(0.0016)
    shade = colour * (1.0 + 0.012 * fibre + 0.02 * grid.noise(0.03, 2))[..., None]
    ink = 1.0 - 0.1 * step(0.3, 0.0, colour.mean(axis=2))
    rough = (ink + 0.06 * grid.noise(0.02, 2)).astype(np.float32)
    return Layers(shade.astype(np.float32), rough, (2e-6 * fibre).astype(np.float32))
