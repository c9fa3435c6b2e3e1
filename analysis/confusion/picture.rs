//! Confusion matrices of types, cells and categories. Rows are true classes, columns are found classes, and colours show
//! the share of the row.

use landscape::evaluation::taxonomy::{Category, GraspType, Taxonomy};
use landscape::figure::{Anchor, Canvas, TextFace, theme};

use crate::Condition;

const SIZE: [u32; 2] = [2060, 1130];
const FACE: TextFace = TextFace::new(22.0, theme::INK);
const TITLE: TextFace = TextFace::new(29.0, theme::INK);

/// A matrix to be drawn.
struct Matrix<'a> {
    title: &'a str,
    /// Names of the rows, and headings of the columns.
    names: Vec<[String; 2]>,
    /// Row of a type.
    row: &'a dyn Fn(&GraspType) -> Option<usize>,
    /// Upper left corner of the first cell.
    corner: [f64; 2],
    /// Side of a cell.
    cell: f64,
    /// Whether the cells contain their shares as text.
    written: bool,
}

pub(crate) fn picture(condition: &Condition) -> Canvas {
    let feix = Taxonomy::feix();
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]).with_pixels_per_unit(1);
    canvas.text(
        [theme::MARGIN, 34.0],
        &format!(
            "What the rule takes each grasp for (row: true, column: found): {}",
            condition.name
        ),
        TITLE,
    );
    let types = feix.types.iter().map(|entry| {
        let number = entry.number.to_string();
        [format!("{} {}", entry.number, entry.name), number]
    });
    Matrix {
        title: "Types",
        names: types.collect(),
        row: &|entry| Some(usize::from(entry.number) - 1),
        corner: [310.0, 130.0],
        cell: 29.0,
        written: false,
    }
    .draw(&mut canvas, condition);
    let cells = feix.cells();
    let letters = ('A'..).map(String::from);
    Matrix {
        title: "Cells",
        names: (cells.iter().zip(letters))
            .map(|(cell, letter)| [format!("{cell} {letter}"), letter])
            .collect(),
        row: &|entry| cells.iter().position(|cell| *cell == entry.cell),
        corner: [1660.0, 130.0],
        cell: 22.0,
        written: false,
    }
    .draw(&mut canvas, condition);
    let categories = [Category::Power, Category::Intermediate, Category::Precision];
    Matrix {
        title: "Categories",
        names: categories
            .map(|category| [category.name().to_owned(), category.name().to_owned()])
            .to_vec(),
        row: &|entry| {
            categories
                .iter()
                .position(|category| *category == entry.category)
        },
        corner: [1520.0, 690.0],
        cell: 132.0,
        written: true,
    }
    .draw(&mut canvas, condition);
    legend(&mut canvas, [310.0, 1096.0]);
    canvas
}

/// Colour of a share of a row. Zero has its own colour.
fn fill(share: f64) -> landscape::figure::Colour {
    if share > 0.0 {
        theme::sequential(1.0 - share)
    } else {
        theme::FAINT
    }
}

impl Matrix<'_> {
    fn draw(&self, canvas: &mut Canvas, condition: &Condition) {
        let feix = Taxonomy::feix();
        let row = |number: Option<u8>| (self.row)(feix.numbered(number?)?);
        let [left, top] = self.corner;
        let size = self.cell * self.names.len() as f64;
        canvas.text(
            [left + 0.5 * size, top - 48.0],
            self.title,
            TITLE.anchored(Anchor::Middle),
        );
        for (at, [name, head]) in self.names.iter().enumerate() {
            let middle = (at as f64 + 0.5) * self.cell;
            canvas.text([left - 8.0, top + middle], name, FACE.anchored(Anchor::End));
            canvas.text(
                [left + middle, top - 14.0],
                head,
                FACE.anchored(Anchor::Middle),
            );
            let of_row: Vec<Option<usize>> = (condition.outcomes.iter())
                .filter(|outcome| row(outcome.truth) == Some(at))
                .map(|outcome| row(outcome.found()))
                .collect();
            for column in 0..self.names.len() {
                let found = of_row.iter().filter(|found| **found == Some(column));
                let share = found.count() as f64 / of_row.len().max(1) as f64;
                let corner = [
                    left + self.cell * column as f64,
                    top + self.cell * at as f64,
                ];
                let far = corner.map(|c| c + self.cell - 1.0);
                canvas.rectangle(corner, far, fill(share));
                if self.written {
                    let ink = if share > 0.45 {
                        theme::WHITE
                    } else {
                        theme::INK
                    };
                    canvas.text(
                        corner.map(|c| c + 0.5 * self.cell),
                        &format!("{share:.2}"),
                        TextFace::new(theme::TEXT, ink).anchored(Anchor::Middle),
                    );
                }
            }
        }
    }
}

fn legend(canvas: &mut Canvas, [x, y]: [f64; 2]) {
    canvas.text([x, y + 12.0], "Share of the row:", FACE);
    for step in 0..=10u32 {
        let share = f64::from(step) / 10.0;
        let left = x + 200.0 + 56.0 * f64::from(step);
        canvas.rectangle([left, y], [left + 55.0, y + 26.0], fill(share));
        let ink = if share > 0.45 {
            theme::WHITE
        } else {
            theme::INK
        };
        canvas.text(
            [left + 28.0, y + 13.0],
            &format!("{share:.1}"),
            TextFace::new(20.0, ink).anchored(Anchor::Middle),
        );
    }
}
