"""A small d3plot in the layout of LS-DYNA's database manual: no program of Debian writes one."""

import numpy as np


def write_d3plot(path, nodes, solids, shells, states):
    """`nodes`: {number: point}; `solids`, `shells`: {number: (part, nodes)}; `states`: (time, points, velocities, numbers of
    deleted elements)."""
    parts = sorted({part for part, _ in [*solids.values(), *shells.values()]})
    row = {number: k + 1 for k, number in enumerate(nodes)}
    control, points, count = np.zeros(64, "<i4"), np.array(list(nodes.values()), "<f4"), len(parts)
    control[:10] = np.frombuffer(b"boxes".ljust(40), "<i4")
    control[14] = np.array([971.0], "<f4").view("<i4")[0]
    arbitrary = 10 + 6 + len(nodes) + len(solids) + len(shells) + 3 * count
    for at, value in {15: 4, 16: len(nodes), 17: 6, 18: 6, 20: 1, 21: 1, 23: len(solids), 24: len({part for part, _ in solids.values()}), 27: 7, 31: len(shells),
                      32: len({part for part, _ in shells.values()}), 33: 33, 36: -10003, 39: arbitrary, 43: 1000, 44: 1000, 45: 1000, 46: 1000, 51: count}.items():
        control[at] = value
    words = [control, points]
    for table in (solids, shells):
        words.append(np.array([[*(row[node] for node in members), 1 + parts.index(part)] for part, members in table.values()], "<i4"))
    first = 1
    words.append(np.array([-1, first, 1, 1, 1, len(nodes), len(solids), 0, len(shells), 0, 1, 1, 1, count, 0, count], "<i4"))
    for numbers in (nodes, solids, shells, parts, parts, parts):
        words.append(np.array(list(numbers), "<i4"))
    words.append(np.array([-999999.0], "<f4"))
    static = b"".join(part.tobytes() for part in words)
    body = b""
    for time, place, velocity, deleted in states:
        alive = [0.0 if number in deleted else 1.0 for number in [*solids, *shells]]
        values = [[time], np.zeros(6), np.asarray(place).ravel(), np.asarray(velocity).ravel(), np.zeros(7 * len(solids)),
                  np.zeros(33 * len(shells)), alive]
        body += np.concatenate(values).astype("<f4").tobytes()
    with open(path, "wb") as file:
        file.write(static)
    with open(path + "01", "wb") as file:
        file.write(body + np.array([-999999.0], "<f4").tobytes())
