"""Names, labels and notes that look like markup, or turn the direction of writing, stay text wherever the page shows them."""

import pyarrow.parquet as pq

import made
from browsing import says

ATTACK = """</script><script>window.hurt=1</script><img src=x onerror="window.hurt=1"><!-- ]]> '&amp;"""

#: Shows everything, and returns what came of it.
LOOK = r"""
await settled();
const [a, b] = [0, 1].map(item => model.name(item));
location.hash = `sel=${encodeURIComponent(a)},${encodeURIComponent(b)}&pin=${encodeURIComponent(a)}&level=0.2`;
await wait(300);
change({ hover: 0 });
await settled();
if (panels.tree) await point(panels.tree.drawing.canvas, "pointermove", panels.tree.at(0));
const caption = document.querySelector("#scene .caption")?.textContent ?? "";
const tipped = byId("tip").textContent;
for (const details of document.querySelectorAll("#trust details")) details.open = true;
const drawings = Object.values(panels).filter(panel => panel.drawing).map(panel => panel.drawing.svg());
const parsed = drawings.every(svg => !new DOMParser().parseFromString(svg, "image/svg+xml").querySelector("parsererror"));
panels.label?.open();
byId("export-open").click();
await settled();
return {
  title: byId("title").textContent,
  tab: document.title,
  trust: byId("trust").textContent,
  made: byId("made").textContent,
  cells: [...document.querySelectorAll("#table [role=gridcell]")].map(cell => cell.textContent),
  caption, tipped, parsed,
  cards: byId("labelling").textContent,
  commands: byId("commands").textContent,
  hurt: window.hurt ?? null,
  images: document.images.length,
  // The data are taken away at the start.
  scripts: document.scripts.length,
  wide: document.documentElement.scrollWidth <= innerWidth,
  high: byId("title").getBoundingClientRect().height,
};
"""


def hostile(what):
    """Ends a script and begins one, hides what follows, holds quotes and marks that turn the direction of writing; then long."""
    return f"{what} {ATTACK} \u202eekil\u2067 {'long' * 200}"


def looked_at(desk, opened, shown):
    """What the page of a landscape or of a file of grasps shows; nothing of it was run."""
    desk.succeed("report", "-q", "--force", "-o", "hostile.html", shown)
    assert (desk.folder / "hostile.html").read_text().count("<script") == 3, "names stand in the packed data only"
    told = opened(desk.folder / "hostile.html").act(LOOK)
    assert (told["hurt"], told["images"], told["scripts"]) == (None, 0, 2)
    assert told["parsed"], "saved pictures are proper XML"
    assert told["wide"], "a long name does not widen the page"
    assert told["high"] < 120, "a long title takes a few lines"
    # What stands in one sentence with other words must not turn these.
    for words in (told["caption"], told["tipped"], told["cards"]):
        assert not set(words) & {"\u202e", "\u2067"}
    return told


def test_hostile_names_of_a_landscape_stay_text(desk, opened):
    folder = made.landscape(desk.folder / "<b>&quot;'.landscape", 12, 3)

    def change(manifest, rows):
        manifest["object"]["name"], manifest["hand"]["name"] = hostile("object"), hostile("hand")
        manifest["command"], manifest["warnings"] = hostile("command"), [hostile("note")]
        for edge in rows["edges"]:
            edge["term"], edge["way"] = hostile("term"), hostile("way")
        for row in rows["minima"]:
            row["labels"], row["label_counts"] = [hostile("label")], [1]

    made.changed(folder, change)
    told = looked_at(desk, opened, folder)
    says(told["title"], hostile("object"))
    says(told["trust"], hostile("ote"))
    says(told["commands"], "landscape inspect '<b>&quot;'\\''.landscape' --path m0 m1")


def test_hostile_names_of_a_population_stay_text(desk, opened):
    table, described = made.grasps(4), made.metadata(exact=False)
    for name in ("object", "hand", "label"):
        table = made.with_column(table, name, [hostile(name)] * 4)
    for kind in ("object", "hand"):
        for named in described[f"{kind}s"]:
            named["name"] = hostile(kind)
    name = "<script>window.hurt=1<!--\u202e.parquet"
    pq.write_table(made.described(table, {**described, "command": hostile("command")}), desk.folder / name)
    told = looked_at(desk, opened, name)
    assert hostile("label") in told["cells"]
    says(told["title"], "<script>")


def test_hostile_names_of_a_surface_stay_text(desk, opened):
    desk.succeed("surface", "muller-brown", "-q", "--no-report")

    def change(manifest, rows):
        manifest["source"]["name"], manifest["command"], manifest["warnings"] = hostile("surface"), hostile("command"), [hostile("note")]

    made.changed(desk.folder / "muller-brown.landscape", change)
    told = looked_at(desk, opened, "muller-brown.landscape")
    says(told["title"], hostile("surface"))
    says(told["trust"], hostile("ote"))
