//! numpy arrays: a type of items, a shape, and bytes.

/// The type of an array's items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Type {
    Object,
    Number { kind: u8, size: usize, big: bool },
}

impl Type {
    /// Reads a type in numpy's notation: `<f8`, `|O`, `i4`.
    pub(crate) fn parse(code: &str) -> Result<Self, String> {
        let unknown = || format!("its items are of type {code}; numbers or objects are needed");
        let plain = code.trim_start_matches(['<', '>', '=', '|']);
        let mut letters = plain.chars();
        let kind = letters.next().ok_or_else(unknown)?;
        if kind == 'O' {
            return Ok(Self::Object);
        }
        let size: usize = letters.as_str().parse().ok().ok_or_else(unknown)?;
        let known = matches!(
            (kind, size),
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1)
        );
        let kind = u8::try_from(kind)
            .ok()
            .filter(|_| known)
            .ok_or_else(unknown)?;
        Ok(Self::Number {
            kind,
            size,
            big: code.starts_with('>'),
        })
    }

    /// The type with the byte order `<`, `>` or none.
    pub(crate) fn ordered(self, order: &str) -> Self {
        match self {
            Self::Number { kind, size, .. } => Self::Number {
                kind,
                size,
                big: order == ">",
            },
            Self::Object => self,
        }
    }

    /// The first `count` numbers in `bytes`.
    pub(crate) fn numbers(self, bytes: &[u8], count: usize) -> Result<Vec<f64>, String> {
        let Self::Number { kind, size, big } = self else {
            return Err("it has objects where numbers are needed".to_owned());
        };
        let needed = count.checked_mul(size);
        let bytes = needed.and_then(|needed| bytes.get(..needed));
        let bytes =
            bytes.ok_or_else(|| format!("it is cut short: {count} numbers are announced"))?;
        let items = bytes.chunks_exact(size);
        Ok(items.map(|item| number(kind, big, item)).collect())
    }

    /// The numbers in `bytes` at these places, which count items.
    pub(crate) fn numbers_at(
        self,
        bytes: &[u8],
        places: impl Iterator<Item = usize>,
    ) -> Result<Vec<f64>, String> {
        let Self::Number { kind, size, big } = self else {
            return Err("it has objects where numbers are needed".to_owned());
        };
        let item = |place: usize| {
            let start = place.checked_mul(size)?;
            let item = bytes.get(start..start.checked_add(size)?)?;
            Some(number(kind, big, item))
        };
        let numbers: Option<Vec<f64>> = places.map(item).collect();
        numbers.ok_or_else(|| "it has a tensor that reaches beyond its storage".to_owned())
    }
}

/// A number of a kind from its bytes, of which there are at most eight.
fn number(kind: u8, big: bool, item: &[u8]) -> f64 {
    let mut word = [0; 8];
    let size = item.len();
    word[..size].copy_from_slice(item);
    if big {
        word[..size].reverse();
    }
    let bits = u64::from_le_bytes(word);
    let [b0, b1, b2, b3, ..] = word;
    match (kind, size) {
        (b'f', 4) => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
        (b'f', _) => f64::from_bits(bits),
        (b'i', 1) => f64::from(i8::from_le_bytes([b0])),
        (b'i', 2) => f64::from(i16::from_le_bytes([b0, b1])),
        (b'i', 4) => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
        (b'i', _) => i64::from_le_bytes(word) as f64,
        _ => bits as f64,
    }
}

/// An array of numbers in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Numbers {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

impl Numbers {
    pub(crate) fn decode(
        kind: Type,
        shape: Vec<usize>,
        fortran: bool,
        bytes: &[u8],
    ) -> Result<Self, String> {
        let count = shape
            .iter()
            .try_fold(1usize, |n, &side| n.checked_mul(side));
        let count = count.ok_or_else(|| format!("it has an array of shape {shape:?}"))?;
        let mut values = kind.numbers(bytes, count)?;
        if fortran {
            values = in_c_order(&shape, &values);
        }
        Ok(Self { shape, values })
    }

    /// Rows of equal length. A one-dimensional array is a single row.
    pub(crate) fn rows(&self) -> Option<Vec<Vec<f64>>> {
        match self.shape[..] {
            [_] => Some(vec![self.values.clone()]),
            [_, columns] if columns > 0 => Some(
                self.values
                    .chunks_exact(columns)
                    .map(<[f64]>::to_vec)
                    .collect(),
            ),
            _ => None,
        }
    }
}

/// Converts from column-major to row-major order.
fn in_c_order(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let mut stride = 1;
    let sides = shape.iter().filter(|side| **side > 1).map(|&side| {
        let step = stride;
        stride *= side;
        (side, step)
    });
    let sides: Vec<(usize, usize)> = sides.collect();
    let place = |index| {
        let indices = sides.iter().rev().scan(index, |rest, (side, step)| {
            let index = *rest % side;
            *rest /= side;
            Some(index * step)
        });
        indices.sum::<usize>()
    };
    (0..values.len()).map(|i| values[place(i)]).collect()
}
