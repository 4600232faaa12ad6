"""Closed surfaces that `bench_meshing.py` fills with tets, made from nothing: round, planar, thin, sharp, divided.

A `Surface` bounds one region or several; a triangle's patch is the pair of regions that it lies between, 0 being
outside. Only tessellations live here: nothing about programs or files."""

import heapq
import itertools
import math


class Surface:
    def __init__(self, points, triangles, sides, holes=()):
        """points: (x, y, z); triangles: point indices, from 0; sides: a pair of regions for each triangle;
        holes: a point in each void that a shell encloses."""
        self.points, self.triangles, self.sides, self.holes = points, triangles, sides, list(holes)
        self.patches = {pair: i for i, pair in enumerate(sorted(set(sides)), 1)}

    def refs(self):
        return [self.patches[pair] for pair in self.sides]

    def regions(self):
        """Region -> its patches."""
        numbers = sorted({region for pair in self.patches for region in pair if region > 0})
        return {number: [ref for pair, ref in self.patches.items() if number in pair] for number in numbers}


def sphere(frequency, radius=1.0, center=(0.0, 0.0, 0.0)):
    """An icosahedron whose edges are divided `frequency` times: 20 frequency^2 triangles."""
    g = (1 + math.sqrt(5)) / 2
    corners = [(0, s, t * g) for s in (-1, 1) for t in (-1, 1)]
    corners = [point[k:] + point[:k] for point in corners for k in range(3)]
    index, points, triangles = {}, [], []

    def vertex(*weights):
        """The point with these integer weights of corners, pushed out to the sphere; weights name it."""
        name = tuple(sorted((corner, weight) for corner, weight in weights if weight > 0))
        if name not in index:
            index[name] = len(points)
            p = [sum(weight * corners[corner][axis] for corner, weight in name) for axis in range(3)]
            points.append(tuple(c + radius * x / math.hypot(*p) for c, x in zip(center, p)))
        return index[name]

    for face in itertools.combinations(range(12), 3):
        if any(math.dist(corners[i], corners[j]) > 2.1 for i, j in itertools.combinations(face, 2)):
            continue
        at = lambda i, j: vertex((face[0], frequency - i - j), (face[1], i), (face[2], j))
        for i, j in itertools.product(range(frequency), repeat=2):
            if i + j < frequency:
                triangles.append((at(i, j), at(i + 1, j), at(i, j + 1)))
            if i + j + 1 < frequency:
                triangles.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    return Surface(points, triangles, [(0, 1)] * len(triangles))


def cube(squares, length=1.0):
    """A cube around the origin with squares x squares on each side, two triangles each."""
    index, points, triangles = {}, [], []

    def vertex(grid):
        if grid not in index:
            index[grid] = len(points)
            points.append(tuple(length * (x / squares - 0.5) for x in grid))
        return index[grid]

    for axis, end in itertools.product(range(3), (0, squares)):
        for i, j in itertools.product(range(squares), repeat=2):
            a, b, c, d = (vertex(tuple((*uv[:axis], end, *uv[axis:])))
                          for uv in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            triangles += [(a, b, c), (a, c, d)]
    return Surface(points, triangles, [(0, 1)] * len(triangles))


def with_hole(outer, inner, center):
    """The volume between two shells; `center` lies within the inner one."""
    shift = len(outer.points)
    triangles = outer.triangles + [tuple(v + shift for v in triangle) for triangle in inner.triangles]
    return Surface(outer.points + inner.points, triangles, [(0, 1)] * len(triangles), [center])


def comb(teeth, gap, tip=0.0):
    """The outline of a comb of width 4: a bar with teeth on it, `gap` apart, whose upper ends are narrower by the share
    `tip` (1: sharp edges). Returns its points and its polygons: the bar, then the teeth."""
    pitch = 4 / teeth
    left = [i * pitch + (gap / 2 if i > 0 else 0) for i in range(teeth)]
    right = [(i + 1) * pitch - (gap / 2 if i + 1 < teeth else 0) for i in range(teeth)]
    points = [(0.0, 0.0), (4.0, 0.0)]
    polygons, roots = [], []
    for a, b in zip(left, right):
        first = len(points)
        middle, half = (a + b) / 2, (b - a) / 2 * (1 - tip)
        top = [(middle + half, 2.0), (middle - half, 2.0)] if tip < 1 else [(middle, 2.0)]
        points += [(a, 0.6), (b, 0.6), *top]
        polygons.append(list(range(first, len(points))))
        roots += [first, first + 1]
    return points, [[0, 1, *reversed(roots)], *polygons]


def merged(outline):
    """The same outline as one polygon: what its polygons share is left out."""
    points, polygons = outline
    after = {}
    edges = {edge for polygon in polygons for edge in zip(polygon, polygon[1:] + polygon[:1])}
    for a, b in edges:
        if (b, a) not in edges:
            after[a] = b
    start = next(iter(after))
    around = [start]
    while after[around[-1]] != start:
        around.append(after[around[-1]])
    return points, [around]


def ears(points, polygon):
    """Triangulates a simple polygon, counterclockwise, cutting off the ear with the largest least angle."""
    def turn(a, b, c):
        (ax, ay), (bx, by), (cx, cy) = points[a], points[b], points[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    def least_sine(a, b, c):
        sides = [math.dist(points[i], points[j]) for i, j in ((a, b), (b, c), (c, a))]
        return turn(a, b, c) / (max(sides) * sorted(sides)[1])

    left, triangles = list(polygon), []
    while len(left) > 3:
        around = zip(left[-1:] + left[:-1], left, left[1:] + left[:1])
        convex = [ear for ear in around if turn(*ear) > 0]
        free = [(a, b, c) for a, b, c in convex
                if not any(turn(a, b, p) >= 0 and turn(b, c, p) >= 0 and turn(c, a, p) >= 0
                           for p in left if p not in (a, b, c))]
        best = max(free, key=lambda ear: least_sine(*ear))
        triangles.append(best)
        left.remove(best[1])
    return triangles + [tuple(left)]


def extruded(outline, depth):
    """The body between z = 0 and z = depth over an outline; each of its polygons is a region, numbered from 1."""
    flat, polygons = outline
    n = len(flat)
    points = [(x, y, z) for z in (0.0, depth) for x, y in flat]
    triangles, sides, walls = [], [], {}
    for region, polygon in enumerate(polygons, 1):
        for a, b, c in ears(flat, polygon):
            triangles += [(a, c, b), (a + n, b + n, c + n)]
            sides += [(0, region)] * 2
        for a, b in zip(polygon, polygon[1:] + polygon[:1]):
            walls.setdefault((min(a, b), max(a, b)), []).append(region)
    for (a, b), regions in walls.items():
        triangles += [(a, b, b + n), (a, b + n, a + n)]
        sides += [tuple(sorted(([0] + regions)[-2:]))] * 2
    return Surface(points, triangles, sides)


class Division:
    """Triangles that are divided at their longest edges, with Delaunay flips within planes after each."""

    def __init__(self, surface):
        self.points = list(surface.points)
        self.triangles, self.sides, self.at_edge, self.waiting = {}, {}, {}, []
        self.numbers = itertools.count()
        for triangle, pair in zip(surface.triangles, surface.sides):
            self.add(triangle, pair)

    def length(self, edge):
        return math.dist(self.points[edge[0]], self.points[edge[1]])

    def add(self, triangle, pair):
        number = next(self.numbers)
        self.triangles[number], self.sides[number] = triangle, pair
        for edge in itertools.combinations(sorted(triangle), 2):
            self.at_edge.setdefault(edge, set()).add(number)
        heapq.heappush(self.waiting, (-max(self.length(e) for e in itertools.combinations(triangle, 2)), number))
        return number

    def remove(self, number):
        triangle = self.triangles.pop(number)
        for edge in itertools.combinations(sorted(triangle), 2):
            self.at_edge[edge].discard(number)
            if not self.at_edge[edge]:
                del self.at_edge[edge]
        return triangle, self.sides.pop(number)

    def normal(self, triangle):
        a, b, c = (self.points[v] for v in triangle)
        u, w = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        return [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]]

    def angle(self, at, one, other):
        to = [[q - p for p, q in zip(self.points[at], self.points[v])] for v in (one, other)]
        cosine = sum(map(lambda p, q: p * q, *to)) / math.hypot(*to[0]) / math.hypot(*to[1])
        return math.acos(max(-1.0, min(1.0, cosine)))

    def least_angle(self, triangle):
        a, b, c = triangle
        return min(self.angle(a, b, c), self.angle(b, c, a), self.angle(c, a, b))

    def split(self, edge):
        middle = len(self.points)
        self.points.append(tuple((x + y) / 2 for x, y in zip(*(self.points[v] for v in edge))))
        fresh = []
        for number in sorted(self.at_edge[edge]):
            triangle, pair = self.remove(number)
            fresh += [self.add(tuple(middle if v == end else v for v in triangle), pair) for end in edge]
        self.flip([edge for number in fresh for edge in itertools.combinations(sorted(self.triangles[number]), 2)])

    def flip(self, edges):
        """Lawson's flips from these edges on; only within planes."""
        while edges:
            edge = edges.pop()
            around = sorted(self.at_edge.get(edge, ()))
            if len(around) != 2 or self.sides[around[0]] != self.sides[around[1]]:
                continue
            one, other = (self.triangles[number] for number in around)
            c, d = (next(v for v in triangle if v not in edge) for triangle in (one, other))
            if self.angle(c, *edge) + self.angle(d, *edge) < math.pi + 1e-6 or not self.coplanar(one, other):
                continue
            pair = self.sides[around[0]]
            self.remove(around[0])
            self.remove(around[1])
            for end in edge:
                self.add(tuple(d if v == end else v for v in one), pair)
            edges += [tuple(sorted((x, y))) for x in edge for y in (c, d)]

    def coplanar(self, one, other):
        n, m = self.normal(one), self.normal(other)
        cosine = sum(x * y for x, y in zip(n, m)) / math.hypot(*n) / math.hypot(*m)
        return abs(cosine) > 1 - 1e-12


def divided(surface, size, angle=20.0, least=0.0):
    """The same surface with edges up to `size`, and with angles of at least `angle` degrees in triangles longer than
    `least`: so sizes grow from what is narrow. Longest edges are bisected (Rivara 1984), then flipped (Lawson 1977)."""
    division = Division(surface)
    division.flip(list(division.at_edge))
    while division.waiting:
        longest, number = heapq.heappop(division.waiting)
        triangle = division.triangles.get(number)
        if triangle is None:
            continue
        if -longest > size or (-longest > least and division.least_angle(triangle) < math.radians(angle)):
            division.split(max(itertools.combinations(sorted(triangle), 2), key=division.length))
    order = sorted(division.triangles)
    return Surface(division.points, [division.triangles[i] for i in order], [division.sides[i] for i in order],
                   surface.holes)
