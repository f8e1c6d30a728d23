"""Table I: speed-ups over the baselines, beside those printed in the paper."""

import itertools

from matplotlib.lines import Line2D

from .page import DOUBLE, PAPER_MARK, SMALL, Page, log_axis, pipeline_looks, scene_axis, times
from .records import grouped, is_baseline, label_of, mean_over_steps, scenes_of, seconds_with_edit

# Numbers printed in the paper's Table I.
PAPER_SPEEDUP = {"NavCCD": {"octopi": 12, "bullet": 21, "airbag": 10.2, "crash": 12.4, "liver": 10.3},
                 "HashCCD": {"octopi": 18.3, "bullet": 28, "airbag": 13, "crash": 17.4, "liver": 14.1}}


def comparisons(rows, family):
    """Yields (label, baseline's rows, rows) for each pipeline that is no baseline, against the baselines of the
    family. A variant is compared with the baseline of the same variant; if there is none, with the baseline without
    settings."""
    pipelines = grouped(rows, "pipeline", "variant")
    subjects = [key for key in pipelines if not is_baseline(key[0])]
    baselines = [key for key in pipelines if key[0].startswith(family)]

    def like(key, others):
        same = [other for other in others if other[1] == key[1]]
        return same or [other for other in others if not other[1]] or others

    pairs = {(subject, baseline): None for subject in subjects for baseline in like(subject, baselines)}
    pairs |= {(subject, baseline): None for baseline in baselines for subject in like(baseline, subjects)}
    several = len({baseline[0] for baseline in baselines}) > 1
    for subject, baseline in pairs:
        label = label_of(*subject)
        if several or baseline[1] != subject[1]:
            label += " over " + label_of(*baseline)
        yield label, pipelines[baseline], pipelines[subject]


def speedup(baseline, subject):
    """Ratio of the mean times, as in the tables, topology edits included, over the steps that both have; None if they
    share no step."""
    steps = {row["step"] for row in baseline} & {row["step"] for row in subject}
    if not steps:
        return None
    before, after = (mean_over_steps([row for row in rows if row["step"] in steps], seconds_with_edit)
                     for rows in (baseline, subject))
    return before / after


def speedups(record, say):
    """{(family, table, scene): [(label, ratio)]}."""
    result = {}
    for family in PAPER_SPEEDUP:
        for (table, scene), rows in grouped(record.rows, "table", "scene").items():
            entries = result.setdefault((family, table, scene), [])
            for label, baseline, subject in comparisons(rows, family):
                ratio = speedup(baseline, subject)
                if ratio is None:
                    say(f"speedup: table {table}, {scene}, {label}: has no step in common with "
                        f"{baseline[0]['pipeline']}; left out")
                else:
                    entries.append((label, ratio))
    return result


def draw_speedup(record, say):
    """Draws the speed-ups. Comparisons of a pipeline with another variant of a baseline are on a page of their own."""
    ratios = speedups(record, say)
    pages = []
    for name, wanted in (("speedup", False), ("speedup-variants", True)):
        some = {key: [entry for entry in entries if (" over " in entry[0]) == wanted]
                for key, entries in ratios.items()}
        if any(some.values()):
            families = [family for family in PAPER_SPEEDUP if any(some[key] for key in some if key[0] == family)]
            tables = sorted({table for (_, table, _), entries in some.items() if entries})
            scenes = [scene for scene in scenes_of(record.rows) if any(some[key] for key in some if key[2] == scene)]
            pages.append((name, speedup_page(record, some, families, tables, scenes)))
    return pages


def speedup_page(record, ratios, families, tables, scenes):
    slots = max(map(len, ratios.values())) + 1
    pitch = slots + 0.8
    page = Page(DOUBLE, len(families) * (12 + 3.3 * pitch * len(scenes)), len(families), len(tables), sharex=True,
                sharey=True)
    looks = pipeline_looks()
    every = [ratio for entries in ratios.values() for _, ratio in entries]
    every += [factor for printed in PAPER_SPEEDUP.values() for factor in printed.values()]
    low = min(0.9, *every) / 1.2
    high = max(every) * (max(every) / low) ** 0.35  # leaves room for the numbers beside marks
    for (family, panels), (column, table) in itertools.product(zip(families, page.panels), enumerate(tables)):
        panel = panels[column]
        names = {row["pipeline"] for row in record.rows if row["table"] == table and row["pipeline"].startswith(family)}
        panel.set(xscale="log", xlim=(low, high), title=f"I-{table}: over {', '.join(sorted(names)) or family}")
        for i, scene in enumerate(scenes):
            if i % 2:
                panel.axhspan(i * pitch - 0.9, i * pitch + slots - 0.1, color="#f2f2f2", linewidth=0)
            draw_speedups(page, panel, i * pitch, ratios.get((family, table, scene), []), looks,
                          PAPER_SPEEDUP[family].get(scene))
        panel.axvline(1, color="black", linewidth=0.6)
        log_axis(panel.xaxis)
        panel.set_ylim(len(scenes) * pitch - 0.9, -0.9)
        scene_axis(panel, [i * pitch + (slots - 1) / 2 for i in range(len(scenes))], scenes)
    for panel in page.panels[-1]:
        panel.set_xlabel("speed-up (ratio of mean times)" if len(tables) < 4 else "speed-up")
    return page


def draw_speedups(page, panel, y, entries, looks, printed):
    """Draws the speed-ups of one scene, one below the other, with the paper's at the end."""
    marks = [(label, ratio, looks.marker(label), times(ratio)) for label, ratio in entries]
    marks += [("paper (Table I, as printed)", printed, PAPER_MARK, f"{printed:g}×")] if printed else []
    for j, (label, ratio, look, text) in enumerate(marks):
        panel.plot([1, ratio], [y + j, y + j], color="#888888", linewidth=0.6)
        panel.plot([ratio], [y + j], **look)
        panel.annotate(text, (ratio, y + j), (4, 0), textcoords="offset points", va="center", fontsize=SMALL)
        page.legend(label, Line2D([], [], **{**look, "linestyle": "none"}))
