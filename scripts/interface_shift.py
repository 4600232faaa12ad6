"""The paper's sequence of pictures of one interface shift, in two subdomains: which tets are handed over is found by place.

The runs without and with one shift begin alike, and a shift's new interface is frozen while its tets are adapted: a tet
of the mesh before the shift belongs to the subdomain that has its place in the mesh after it. weft itself looks for the
place: a field that is -1 in the first subdomain, 0 on the interface and 1 in the second, interpolated to the other mesh.
"""

SUBDOMAINS = 2
HANDED_OVER = SUBDOMAINS + 1  # the reference of such tets in the picture


class Pieces:
    """A mesh that weft has written as .pvtu, and the subdomain (from 0) of each of its tets."""

    def __init__(self, book, name):
        self.book, self.name = book, name
        book.call("convert", f"{name}.pvtu", f"{name}.mesh", "--quiet")
        self.lines = (book.folder / f"{name}.mesh").read_text().splitlines()
        self.vertices = [tuple(line.split()[:3]) for line in section(self.lines, "Vertices")]
        self.tets = [tuple(int(v) - 1 for v in line.split()[:4]) for line in section(self.lines, "Tetrahedra")]
        of_tet, self.holders = {}, {}  # by coordinates, which are the same text in all pieces
        for piece in range(SUBDOMAINS):
            book.call("convert", f"{name}_{piece}.vtu", "piece.mesh", "--quiet")
            lines = (book.folder / "piece.mesh").read_text().splitlines()
            vertices = [tuple(line.split()[:3]) for line in section(lines, "Vertices")]
            for vertex in vertices:
                self.holders.setdefault(vertex, set()).add(piece)
            for line in section(lines, "Tetrahedra"):
                of_tet[frozenset(vertices[int(v) - 1] for v in line.split()[:4])] = piece
        self.subdomains = [of_tet[frozenset(self.vertices[v] for v in tet)] for tet in self.tets]

    def write(self, name, references):
        """The mesh with these references of its tets, for a picture."""
        at = self.lines.index("Tetrahedra") + 2
        lines = list(self.lines)
        for i, (tet, reference) in enumerate(zip(self.tets, references)):
            lines[at + i] = " ".join(str(v + 1) for v in tet) + f" {reference}"
        (self.book.folder / f"{name}.mesh").write_text("\n".join(lines) + "\n")

    def sides(self):
        """At each vertex -1 in the first subdomain, 0 on the interface, 1 in the second."""
        return [0 if len(self.holders[v]) > 1 else 2 * min(self.holders[v]) - 1 for v in self.vertices]


def around_interface(vertices, holders, reach=0.6):
    """The box of a picture of the symmetry plane: what is about the interface's place beside the wing."""
    points = [tuple(map(float, v)) for v in vertices if len(holders[v]) > 1]
    near = [x for x, y, z in points if y < reach / 2 and abs(z) < reach / 2] or [x for x, _, _ in points]
    middle = sum(near) / len(near)
    return f"{middle - reach:.3f},0,{-reach / 2},{middle + reach:.3f},1,{reach / 2}"


def shifts_made(report):
    """Those that --shifts limits: not those of phases to coarser metrics."""
    subdomains = report["subdomains"]
    return len(subdomains["shifts"]) - subdomains["coarse_shifts"]


def section(lines, keyword):
    """The lines of one keyword of a .mesh or .sol."""
    at = lines.index(keyword)
    return lines[at + 2:at + 2 + int(lines[at + 1])]


def subdomains_after(tets, before, sides, rounding=1e-9):
    """Of tets, by what the field of sides is at their vertices; those that only touch the interface stay where they are."""
    after = []
    for tet, subdomain in zip(tets, before):
        side = sum(sides[v] for v in tet)
        after.append(subdomain if abs(side) < rounding else int(side > 0))
    return after


def after_shift(book, before, after):
    """The subdomain that each tet of `before` has after the shift."""
    field = "\n".join(map(str, after.sides()))
    (book.folder / "sides.sol").write_text(f"MeshVersionFormatted 2\n\nDimension 3\n\nSolAtVertices\n{len(after.vertices)}\n1 1\n{field}\nEnd\n")
    book.call("interpolate", f"{after.name}.mesh", f"{before.name}.mesh", "--field", "sides.sol", "-o", "sides-before.sol", "--quiet")
    lines = (book.folder / "sides-before.sol").read_text().split()
    at = lines.index("SolAtVertices") + 1
    sides = [float(v) for v in lines[at + 3:at + 3 + int(lines[at])]]
    return subdomains_after(before.tets, before.subdomains, sides)


def sequence(book, case):
    """Runs, draws, and returns the figure's found line and its body."""
    runs = {}
    for name, words in (("before", ("--shifts", 0)), ("after", ("--shifts", 1)), ("end", ())):
        runs[name] = book.adapt(case, f"shift-{name}", "--subdomains", SUBDOMAINS, "--partitioner", f"pqr:{SUBDOMAINS}x1x1", "--threads", 1,
                                "--no-interface-refinement", *words, result=f"shift-{name}.pvtu")
    before, after = (Pieces(book, f"shift-{name}") for name in ("before", "after"))
    view = ("--from", "-y", "--focus", around_interface(before.vertices, before.holders))
    handed = after_shift(book, before, after)
    moved = sum(a != b for a, b in zip(before.subdomains, handed))
    before.write("shift-a", [s + 1 for s in before.subdomains])
    before.write("shift-b", [HANDED_OVER if s != t else s + 1 for s, t in zip(before.subdomains, handed)])
    after.write("shift-c", [s + 1 for s in after.subdomains])
    rows = [book.picture("shift-a", "shift-a.mesh", *view, "--color-by", "subdomain", "--title", "(a) decomposition, interiors adapted"),
            book.picture("shift-b", "shift-b.mesh", *view, "--color-by", "subdomain", "--title", f"(b) transfer: {HANDED_OVER} is handed over"),
            book.picture("shift-c", "shift-c.mesh", *view, "--color-by", "subdomain", "--title", "(c) former interface adapted")]
    for name, title in (("before", "(a), (b): what does not conform"), ("after", "(c): what does not conform"), ("end", "(d) after the last shift")):
        rows.append(book.picture(f"shift-{name}", f"shift-{name}.pvtu", "--metric", f"shift-{name}.pvtu", *view, "--color-by", "nonconforming", "--title", title))
    reported = runs["after"]["subdomains"]["shifts"][-1]["tets_moved"]
    unit = {name: 100 * run["subdomains"]["former_interface"]["edge_length"]["share_unit"] for name, run in runs.items()}
    found = (f"the shift hands over {reported:,} tets ({moved:,} of those in (a), by place); where the interface was, {unit['before']:.1f} % of the edges are "
             f"unit in (a), {unit['after']:.1f} % in (c), {unit['end']:.1f} % in (d). (a), (c) and (d) are results of runs with 0, 1 and {shifts_made(runs['end'])} shifts")
    return found, "".join(rows)
