#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The capsule of this case in an unbounded Stokes flow, by boundary elements, to compare with.

    boundary_elements.py CA [--refinements 3] [--step 0.01] [--end 4] [--skalak C]

With one viscosity inside and outside the velocity of the membrane is that of the shear and of its
forces, the integral of the Stokeslet. Triangles from an icosahedron, the law as in Feib; six points
a triangle, polar coordinates on those that hold the node. The units are mu, k, a = 1. Needs
Debian's python3-numpy.
"""

import argparse

import numpy as np


def icosphere(n_refinements):
    p = (1 + 5**0.5) / 2
    x = [[-1, p, 0], [1, p, 0], [-1, -p, 0], [1, -p, 0], [0, -1, p], [0, 1, p]]
    x += [[0, -1, -p], [0, 1, -p], [p, 0, -1], [p, 0, 1], [-p, 0, -1], [-p, 0, 1]]
    x = [np.array(v) / np.linalg.norm(v) for v in x]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11)]
    triangles += [(1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)]
    triangles += [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9)]
    triangles += [(4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(n_refinements):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(x)
                x.append((x[a] + x[b]) / np.linalg.norm(x[a] + x[b]))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    # Turned, so that no axis of the mesh is one of the flow.
    c, s, d, t = np.cos(0.3), np.sin(0.3), np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, d, -t], [0, t, d]])
    return np.array(x) @ turn.T, np.array(triangles)


class Capsule:
    def __init__(self, modulus, n_refinements, area_ratio):
        self.modulus, self.area_ratio = modulus, area_ratio
        self.x, self.triangles = icosphere(n_refinements)
        e1, e2 = self.edges(self.x)
        self.area = np.linalg.norm(np.cross(e1, e2), axis=1) / 2
        reference = np.zeros((len(self.triangles), 2, 2))
        reference[:, 0, 0] = np.linalg.norm(e1, axis=1)
        reference[:, 0, 1] = np.sum(e1 * e2, 1) / reference[:, 0, 0]
        reference[:, 1, 1] = 2 * self.area / reference[:, 0, 0]
        self.inverse = np.linalg.inv(reference)
        # The sides (i, j, k), (j, k, i), (k, i, j) of all triangles.
        self.i, self.j, self.k = (
            np.concatenate([self.triangles[:, (a + b) % 3] for a in range(3)]) for b in range(3)
        )
        self.own = [[] for _ in self.x]
        for t, triangle in enumerate(self.triangles):
            for node in triangle:
                self.own[node].append(t)

    def edges(self, x):
        a, b, c = (x[self.triangles[:, v]] for v in range(3))
        return b - a, c - a

    def sums(self, nodes, values):
        result = np.zeros(self.x.shape)
        np.add.at(result, nodes, values)
        return result

    def forces(self, x):
        f = np.stack(self.edges(x), 2) @ self.inverse
        c = np.swapaxes(f, 1, 2) @ f
        j2 = np.linalg.det(c)[:, None, None]
        f_inverse = f @ np.linalg.inv(c)
        if self.area_ratio is None:
            stress = f - f_inverse / j2
        else:
            trace = (c[:, 0, 0] + c[:, 1, 1])[:, None, None]
            stress = (trace - 1) * f + (self.area_ratio * (j2 - 1) - 1) * j2 * f_inverse
        h = -self.modulus * self.area[:, None, None] * (stress @ np.swapaxes(self.inverse, 1, 2))
        nodes = self.triangles.T.ravel()
        return self.sums(nodes, np.concatenate([-h[:, :, 0] - h[:, :, 1], h[:, :, 0], h[:, :, 1]]))

    def velocity(self, x):
        area = np.linalg.norm(np.cross(*self.edges(x)), axis=1) / 2
        node_area = self.sums(self.triangles.T.ravel(), np.tile(area / 3, 3)[:, None])
        density = self.forces(x) / node_area

        # Six points, exact for polynomials of degree 4.
        a, b, v, w = 0.445948490915965, 0.091576213509771, 0.223381589678011, 0.109951743655322
        shape = np.array([[r if c != d else 1 - 2 * r for d in range(3)] for r in (a, b) for c in range(3)])
        weight = np.array([v] * 3 + [w] * 3)
        y = np.einsum("qk,tkd->tqd", shape, x[self.triangles]).reshape(-1, 3)
        q = np.einsum("qk,tkd->tqd", shape, density[self.triangles])
        q = (q * (weight[None, :] * area[:, None])[:, :, None]).reshape(-1, 3)
        u = np.zeros(x.shape)
        for first in range(0, len(x), 64):
            nodes = range(first, min(first + 64, len(x)))
            r = x[nodes][:, None, :] - y[None]
            inverse = 1 / np.sqrt(np.einsum("ijk,ijk->ij", r, r))
            for row, node in enumerate(nodes):
                inverse[row].reshape(-1, 6)[self.own[node]] = 0
            along = inverse**3 * np.einsum("ijk,jk->ij", r, q)
            u[nodes] = inverse @ q + np.einsum("ij,ijk->ik", along, r)

        e1, e2 = x[self.j] - x[self.i], x[self.k] - x[self.i]
        area2 = np.linalg.norm(np.cross(e1, e2), axis=1)[:, None]
        near = np.zeros(e1.shape)
        for s, s_weight in zip(*np.polynomial.legendre.leggauss(8)):
            s = (s + 1) / 2
            d = (1 - s) * e1 + s * e2
            length = np.linalg.norm(d, axis=1)[:, None]
            d = d / length
            # The mean of the density along the ray: the Stokeslet is constant on it, times 1/r.
            g = (density[self.i] + (1 - s) * density[self.j] + s * density[self.k]) / 2
            near += s_weight / 2 * area2 / length * (g + d * np.sum(d * g, 1)[:, None])
        u = (u + self.sums(self.i, near)) / (8 * np.pi)
        u[:, 0] += x[:, 1]
        return u

    def moments(self, x):
        """Volume and second moments of what the membrane encloses."""
        t = x[self.triangles]
        volume = np.linalg.det(t) / 6
        centre = (t.sum(1) / 4 * volume[:, None]).sum(0) / volume.sum()
        t = t - centre
        volume = np.linalg.det(t) / 6
        s = t.sum(1)
        second = np.einsum("tki,tkj->tij", t, t) + np.einsum("ti,tj->tij", s, s)
        return volume.sum(), (volume[:, None, None] * second / 20).sum(0) / volume.sum()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("ca", type=float, help="capillary number mu k a/G")
    parser.add_argument("--refinements", type=int, default=3, help="of the icosahedron")
    parser.add_argument("--step", type=float, default=0.01)
    parser.add_argument("--end", type=float, default=4)
    parser.add_argument("--skalak", type=float, metavar="C", help="the law of Skalak instead of the sheet")
    arguments = parser.parse_args()
    capsule = Capsule(1 / arguments.ca, arguments.refinements, arguments.skalak)
    x, initial = capsule.x, capsule.moments(capsule.x)[0]
    print("time deformation inclination volume_change")
    n_steps = round(arguments.end / arguments.step)
    for step in range(1, n_steps + 1):
        x = x + arguments.step * capsule.velocity(x + arguments.step / 2 * capsule.velocity(x))
        if step % max(1, n_steps // 20) == 0:
            volume, m = capsule.moments(x)
            mean, half = (m[0, 0] + m[1, 1]) / 2, np.hypot((m[0, 0] - m[1, 1]) / 2, m[0, 1])
            long, short = np.sqrt(mean + half), np.sqrt(mean - half)
            angle = np.degrees(np.arctan2(2 * m[0, 1], m[0, 0] - m[1, 1])) / 2
            print(
                "%.3f %.5f %.2f %.1e"
                % (step * arguments.step, (long - short) / (long + short), angle, volume / initial - 1),
                flush=True,
            )


if __name__ == "__main__":
    main()
