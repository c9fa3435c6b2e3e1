"""Labels given on the page belong to the grasps of one file, and everything on the page shows the same label."""

import pyarrow.parquet as pq
import pytest

import made
from browsing import says

HOSTILE = [
    "</script><script>window.hurt = 1</script>", '<img src=x onerror="window.hurt = 1">', "\u202eekil\u2066", "--!>\u2028\0",
]

#: A person labels by mouse and keyboard.
LABEL = r"""
const shown = [...document.querySelectorAll("#table .row [role=gridcell]")].map(cell => cell.textContent);
byId("label-start").click();
await settled();
const cards = [...document.querySelectorAll(".card")];
const choice = byId("choice");
const progress = () => byId("label-progress").textContent;
const told = [progress()];
cards[1].click();                                          // the second card, by mouse
await type(choice, "medium");
document.querySelector("#choices li").click();
await settled();
cards[0].focus();
await press(document.activeElement, "Enter");              // the first by keyboard: number 14
await type(choice, "14");
await press(choice, "Enter");
cards[3].focus();
await press(document.activeElement, "0");                  // unlisted
cards[4].focus();
await press(document.activeElement, "Delete");             // no label
told.push(progress());
await wait(1500);
const pictures = [...document.querySelectorAll(".card canvas")].filter(canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some(value => value > 0)).length;
return { shown, told, pictures, hurt: window.hurt ?? null, images: document.images.length };
"""


def test_grasps_are_labelled_on_the_page(desk, opened):
    """The file that the page saves is read back. Texts and numbers of any kind stay what they are."""
    ids = [2**53 + 1, 2**64 - 1, 2**53 + 2, 7, 8, 9]
    table = made.with_column(made.with_column(made.grasps(6), "id", ids), "label", [None, None, *HOSTILE])
    pq.write_table(table, desk.folder / "g.parquet")
    desk.succeed("report", "g.parquet", "-q")
    tab = opened(desk.folder / "g.grasps.html")
    told = tab.act(LABEL)
    assert (told["hurt"], told["images"]) == (None, 0)
    assert set(HOSTILE) | {f"#{ids[1]}"} <= set(told["shown"])
    assert [words.split(";")[0] for words in told["told"]] == ["4 of 6 labelled", "5 of 6 labelled"]
    assert told["pictures"] == 12
    saved, name = tab.saved("label-save")
    csv = saved.decode()
    assert name == "labels.csv" and csv.startswith(f"id,label\n{ids[0]},Tripod\n{ids[1]},Medium Wrap\n")
    says(csv, f"\n{ids[3]},unlisted\n", f"\n{ids[4]},\n")
    ours = [line for line in csv.split("\n") if not set(line) & set("<!\u202e")]
    (desk.folder / "labels.csv").write_text("\n".join(ours))
    desk.succeed("label", "g.parquet", "--from", "labels.csv", "-q")
    labels = pq.read_table(desk.folder / "g.labelled.parquet")["label"].to_pylist()
    assert labels[:2] == ["Tripod", "Medium Wrap"] and labels[4] is None


def test_labels_of_a_file_stay_out_of_another_of_the_same_name(desk, opened):
    """All pages that are opened as files share what a browser keeps. Files that `synth` writes have one name and the ids 0, 1, 2."""
    for folder, first in (("one", 0), ("other", 3)):
        (desk.folder / folder).mkdir()
        table = made.with_column(made.grasps().slice(first, 3), "id", [0, 1, 2])
        pq.write_table(table, desk.folder / folder / "grasps.parquet")
        desk.succeed("report", f"{folder}/grasps.parquet", "-q")
    tab = opened(desk.folder / "one/grasps.grasps.html")
    tab.folder = desk.folder
    tab.act("panels.label.open(); for (const k of [0, 1, 2]) { panels.label.go(k); panels.label.give('Tripod'); } panels.label.close();")
    tab.open("other/grasps.grasps.html")
    assert tab.value("panels.label.csv()") == "id,label\n"
    assert "Tripod" not in tab.value("document.querySelector('#table .rows').textContent")
    assert tab.value("byId('own').checkVisibility()") is False

    # The page of the labelled grasps has them again, says so, and can forget them.
    tab.open("one/grasps.grasps.html")
    count = "panels.label.csv().trim().split('\\n').length - 1"
    assert tab.value("byId('own').textContent") == "3 labels from this browser, not in the file discard"
    assert tab.value(count) == 3
    tab.tab.click("#labels-discard")
    tab.until("document.getElementById('own').textContent.startsWith('labels discarded')")
    assert tab.value(count) == 0
    tab.tab.click("#labels-undo")
    tab.tab.click("#labels-discard")
    tab.reload()
    assert tab.value(count) == 0


def test_the_page_asks_first_for_what_the_labeller_is_least_sure_of(desk, opened):
    """Labels of the file and of the page are passed over, and what a person leaves without a label comes again at the end."""
    table = made.grasps(8)
    ids = [str(number) for number in table["id"].to_pylist()]
    pq.write_table(made.with_column(table, "label", ["Tripod", *[None] * 7]), desk.folder / "g.parquet")
    desk.succeed("label", "g.parquet", "-q")
    desk.succeed("report", "g.parquet", "-q")
    scores = dict(zip(ids, pq.read_table(desk.folder / "g.labelled.parquet")["label_score"].to_pylist()))
    order = sorted(ids[1:], key=scores.get)
    assert order != ids[1:] and all(scores.values())

    tab = opened(desk.folder / "g.grasps.html")
    certainties = dict(tab.value("Array.from({ length: model.count }, (_, item) => [model.name(item).slice(1), model.certainty(item)])"))
    assert certainties == pytest.approx(scores, abs=1e-6)
    tab.tab.click("#label-start")
    keyboard = tab.tab.keyboard

    def asked():
        tab.settle()
        return tab.value("[model.name(Number(document.activeElement.dataset.item)).slice(1), byId('label-progress').textContent]")

    def words(count, number, reason="the labeller is least sure of it"):
        return [number, f"{count} of 8 labelled; next: #{number}, {reason}"]

    assert asked() == words(1, order[0])
    keyboard.press("0")
    assert asked() == words(2, order[1])
    keyboard.press("Space")
    assert asked() == words(2, order[2])
    tab.act("panels.label.go(model.named('#' + given))", order[-1])
    keyboard.press("Enter")
    keyboard.type("14")
    keyboard.press("Enter")
    assert asked() == words(3, order[2])
    for number in order[3:-1]:
        keyboard.press("Space")
        assert asked() == words(3, number)
    keyboard.press("Space")
    assert asked() == words(3, order[1], "left without a label before")

    # In order: from where the person is, round to the first.
    tab.tab.select_option("#label-order", "items")
    for number in [*order[1:-1], order[1]]:
        tab.act("panels.label.go(model.named('#' + given))", number)
        behind = ids[ids.index(number) + 1:] + ids[:ids.index(number)]
        keyboard.press("Space")
        assert asked() == [next(other for other in behind if other in order[1:-1]), "3 of 8 labelled"]


def test_the_order_is_that_of_the_items_where_the_labeller_is_equally_sure(desk, opened):
    pq.write_table(made.grasps(1), desk.folder / "g.parquet")
    desk.succeed("report", "g.parquet", "-q")
    told = opened(desk.folder / "g.grasps.html").act("""
byId("label-start").click();
return [panels.label.current, byId("label-progress").textContent, Boolean(byId("label-order"))];
""")
    assert told == [0, "0 of 1 labelled", False]


#: Gives one item a label that nobody else has, and reads what each part of the page says of it.
GIVE = r"""
await settled();
const item = given;
const wanted = model.header.taxonomy.find(type => !Array.from({ length: model.count }, (_, k) => model.number("type", k)).includes(type.number));
const chart = () => [...document.querySelectorAll("#matrix .chip")].find(chip => chip.title.startsWith(wanted.number + " ")).textContent;
const read = async () => {
  change({ hover: item, colour: "category", level: null });
  await settled();
  const row = document.querySelector(`#table [data-item="${item}"]`);
  const told = {
    table: row.textContent.includes(wanted.name),
    caption: document.querySelector("#scene .caption").textContent.includes(wanted.name),
    dot: lookOf(item).colour === model.key.get(wanted.category).colour && row.querySelector(".dot > *").getAttribute("fill") === lookOf(item).colour,
    chart: chart(),
    legend: document.getElementById("legend").textContent,
  };
  await type(byId("query"), `label = "${wanted.name}" and type = ${wanted.number} and cell = "${wanted.cell}" and category = ${wanted.category}`);
  told.found = derived.passing;
  await type(byId("query"), wanted.name.split(" ")[0].toLowerCase() + ` label = "${wanted.name}"`);
  told.word = derived.passing;
  await type(byId("query"), "");
  return told;
};
const before = await read();
panels.label.open();
panels.label.go(item);
panels.label.give(wanted.name);
panels.label.close();
const after = await read();
panels.label.open();
panels.label.go(item);
panels.label.give("");
panels.label.close();
const again = await read();
return { before, after, again, number: wanted.number, members: model.number("members", item) };
"""


@pytest.mark.parametrize("of", ["landscape", "grasps"])
def test_a_label_is_the_same_in_all_panels(of, desk, explored, opened):
    if of == "grasps":
        pq.write_table(made.grasps(8), desk.folder / "p.parquet")
        desk.succeed("report", "p.parquet", "-q")
    page, item = (explored / "g.report.html", 2) if of == "landscape" else (desk.folder / "p.grasps.html", 0)
    told = opened(page).act(GIVE, item)
    after = told["after"]
    assert after["table"] and after["caption"] and after["dot"]
    assert (after["found"], after["word"]) == (1, 1)
    count = f"{told['number']}·{told['members']}"
    assert after["chart"] == count != told["before"]["chart"], "the chart counts it"
    assert told["again"] == told["before"], "without the label all is as it was"


def test_labels_of_minima_are_saved_only_if_they_were_given_here(explored, opened):
    """The label of a minimum in the files is that of most of its grasps, so only labels that were given on the page are saved."""
    told = opened(explored / "g.report.html").act("""
panels.label.open();
model.sides[0].given = { texts: ['Ring'], of: new Uint8Array(model.count) };
const before = panels.label.csv();
panels.label.go(1); panels.label.give('Tripod'); panels.label.close();
return { before, after: panels.label.csv(), members: model.sides[0].members[1] };
""")
    assert told["before"] == "id,label\n"
    assert told["after"] == "id,label\n" + "".join(f"{number},Tripod\n" for number in told["members"].split(" "))


def test_the_rule_counts_where_a_label_of_the_file_is_taken_away(desk, opened):
    """A label in the file counts until it is taken away on the page; then the rule's does."""
    plain = made.grasps(2)
    given = made.with_column(plain, "label", ["Ring", *plain["label"].to_pylist()[1:]])
    told = []
    for name, table in (("plain", plain), ("given", given)):
        pq.write_table(table, desk.folder / f"{name}.parquet")
        desk.succeed("report", f"{name}.parquet", "-q")
        told.append(opened(desk.folder / f"{name}.grasps.html").act("""
const told = () => [model.text('label', 0), model.number('type', 0), model.text('category', 0)];
const before = told();
panels.label.open(); panels.label.go(0); panels.label.give(''); panels.label.close();
return { before, away: told(), csv: panels.label.csv(), key: model.sides[0].key };
"""))
    assert told[1]["before"][0] == "Ring"
    # What is taken away is written, so that `label --from` takes it away, too.
    assert told[0]["csv"] == "id,label\n"
    assert told[1]["csv"] == f"id,label\n{plain['id'][0].as_py()},\n"
    assert told[0]["key"] == told[1]["key"], "a label in the file changes nothing of whose labels these are"
    assert told[1]["away"] == told[0]["before"]
